// Bounding boxes of bodies, and the test that tells which vertices lie beside such a box.
//
// Both serve culling in the stage `transform`: BodyBoxes finds which bodies can touch at all,
// BoxSides which triangles of a body certainly miss the box of its partners.
#pragma once

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/cpu/primitive.h"
#include "core/predicates/aabb.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Tells on which sides of a closed box a point certainly lies, one bit a side. `growth_m` >= 0 [m]
// is by how much the boxes of triangles grow, as in inflated().
//
// If three vertices have a bit in common, the grown box of their triangle does not intersect this
// box. The opposite does not hold: a triangle right beside the box may have no common bit. Points
// must be finite.
class BoxSides {
 public:
  BoxSides(const Aabb& box, float growth_m)
      : low_{largestBelow(box.min.x, growth_m), largestBelow(box.min.y, growth_m),
             largestBelow(box.min.z, growth_m)},
        high_{-largestBelow(-box.max.x, growth_m), -largestBelow(-box.max.y, growth_m),
              -largestBelow(-box.max.z, growth_m)} {}

  // Returns the six bits of a point. It uses | instead of || so that there are no branches.
  std::uint8_t of(const Vec3f& p) const {
    return static_cast<std::uint8_t>((p.x <= low_.x) | (p.x >= high_.x) << 1 |
                                     (p.y <= low_.y) << 2 | (p.y >= high_.y) << 3 |
                                     (p.z <= low_.z) << 4 | (p.z >= high_.z) << 5);
  }

 private:
  // Returns a number such that every coordinate up to it stays below `bound` after growing. It is
  // nearly the largest one.
  static float largestBelow(float bound, float growth_m) {
    const float x = bound - growth_m - 4e-7F * (std::fabs(bound) + growth_m) - FLT_MIN;
    return inflated(Aabb{{x, x, x}, {x, x, x}}, growth_m).max.x < bound ? x : -INFINITY;
  }

  Vec3f low_, high_;
};

// The boxes of the bodies that a body may touch, as far as they meet its own box. Box is Aabb or
// MovingBox.
template <class Box>
struct PartnerBoxes {
  bool self = false;  // it is its own partner: every triangle counts
  Box bound;          // of all of them
  std::vector<Box> boxes;

  // Returns whether a box meets the box of a partner. The common box decides first.
  bool meet(const Box& box) const {
    if (self) return true;
    return intersects(bound, box) &&
           std::any_of(boxes.begin(), boxes.end(),
                       [&box](const Box& partner) { return intersects(partner, box); });
  }
};

// Computes the bodies' boxes, and keeps those of bodies whose vertices did not change from call to
// call.
class BodyBoxes {
 public:
  // The default uses all vertices. With `most_vertices` only that many, evenly spread over their
  // order: enough to guess where a body is.
  BodyBoxes() = default;
  explicit BodyBoxes(std::size_t most_vertices) : most_vertices_(most_vertices) {}

  // Computes the boxes of all bodies that take part; those of other bodies are unspecified.
  template <class Primitive>
  void update(const Scene& scene, const Options& options, const CycleLimit& limit);

  // Returns the partners of a body. update() must have been called with the same Primitive.
  template <class Primitive>
  PartnerBoxes<BoxOf<Primitive>> partnersOf(const Scene& scene, BodyId id) const;

  // Returns true only if every vertex is known to be finite, as received and as transformed, in all
  // states.
  bool allFinite(BodyId id) const { return all_finite_[id]; }

 private:
  struct ReceivedBox {
    std::uint64_t vertices_revision = 0;  // none has 0
    Aabb box;                             // of the finite vertices, body frame [m]
    bool all_finite = true;
  };

  bool updateReceived(std::uint64_t revision, const HostList<float>& xyz, const CycleLimit& limit,
                      ReceivedBox& received) const;

  std::size_t most_vertices_ = std::numeric_limits<std::size_t>::max();
  std::vector<ReceivedBox> received_, earlier_received_;
  // Each box holds every finite vertex of its body that was used, transformed to float32 and grown
  // by growthOf() [m]. In discrete detection only `to` is filled in.
  std::vector<MovingBox> posed_;
  std::vector<bool> all_finite_;
};

}  // namespace deformable_contact_monitor
