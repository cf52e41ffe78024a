// Holds the components of one body in the scene frame, with boxes around them.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/analysis/mesh_components.h"
#include "core/analysis/point_tree.h"
#include "core/common/cycle_limit.h"
#include "core/common/posed_body.h"
#include "core/predicates/aabb.h"

namespace deformable_contact_monitor {

// Poses the components of a body in each cycle, and keeps what does not change between cycles. One
// thread at a time.
class PosedComponents {
 public:
  // Begins a cycle. The body must live, unchanged, until the next update(). Returns false if the
  // limit was over before the end.
  bool update(const Body& body, const CycleLimit& limit) {
    posed_.emplace(body);
    tree_.reset();
    if (!components_.update(body, limit)) return false;
    const MeshComponents& components = components_.get();
    box_ = Aabb();
    boxes_.assign(components.count(), Aabb());
    is_finite_ = true;
    constexpr std::uint64_t kStepsALook = 1 << 12;
    PacedLimit pace(limit, kStepsALook);
    for (std::uint32_t c = 0; c < components.count(); ++c) {
      for (std::uint32_t i = components.first[c]; i < components.first[c + 1]; ++i) {
        if (pace.over()) return false;
        const Triangle triangle = posed_->triangle(components.triangles[i]);
        is_finite_ = is_finite_ && isFinite(triangle);
        boxes_[c].include(boxOf(triangle));
      }
      box_.include(boxes_[c]);
    }
    return true;
  }

  const MeshComponents& components() const { return components_.get(); }
  const PosedBody& posed() const { return *posed_; }
  // Returns whether the pose keeps all triangles finite that were received finite.
  bool isFinitePosed() const { return is_finite_; }
  const Aabb& box() const { return box_; }
  const Aabb& box(std::uint32_t component) const { return boxes_[component]; }

  // Returns some point of the component [m].
  Vec3f point(std::uint32_t component) const {
    const MeshComponents& of = components();
    return posed_->triangle(of.triangles[of.first[component]]).v[0];
  }

  // Returns a tree of one point of each component, in the order of components. Makes it on the
  // first call after update().
  const PointTree& tree() {
    if (!tree_) {
      std::vector<Vec3f> points;
      points.reserve(components().count());
      for (std::uint32_t c = 0; c < components().count(); ++c) points.push_back(point(c));
      tree_.emplace(std::move(points));
    }
    return *tree_;
  }

  // Returns the mean of the corners of the component's triangles [m].
  Vec3d centroid(std::uint32_t component) const {
    const MeshComponents& of = components();
    Vec3d sum;
    for (std::uint32_t i = of.first[component]; i < of.first[component + 1]; ++i) {
      for (const Vec3f& corner : posed_->triangle(of.triangles[i]).v) sum = sum + toDouble(corner);
    }
    return sum * (1.0 / (3.0 * (of.first[component + 1] - of.first[component])));
  }

 private:
  BodyComponents components_;
  std::optional<PosedBody> posed_;
  std::optional<PointTree> tree_;
  std::vector<Aabb> boxes_;  // by component
  Aabb box_;
  bool is_finite_ = true;
};

}  // namespace deformable_contact_monitor
