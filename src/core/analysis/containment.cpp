// Finds components that lie within closed components of other bodies. A component that touches no
// triangle of a closed surface is on one side of it, so one point decides for all of it. A ray
// upwards from that point crosses a layer of the surface an odd number of times iff the point is
// inside. Boxes and a tree of points leave few pairs of a point and a triangle for the exact test.
#include "core/analysis/containment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "core/analysis/mesh_components.h"
#include "core/common/posed_body.h"
#include "core/common/scene_queries.h"
#include "core/predicates/aabb.h"
#include "core/predicates/ray_crossing.h"

namespace deformable_contact_monitor {

namespace {

// A balanced k-d tree that halves the points along x, y and z in turn. It only compares
// coordinates, so equal, distant and clustered points cost no more than others. With n points a
// query takes about n^(2/3) steps at most, and one more for each point found. Any number of threads
// may query.
class PointTree {
 public:
  // Takes finite points.
  explicit PointTree(std::vector<Vec3f> points) : points_(std::move(points)) {
    order_.resize(points_.size());
    std::iota(order_.begin(), order_.end(), 0U);
    halve(0, order_.size(), 0);
  }

  // Calls visit(index) for each point within the closed box, in any order.
  template <class Visit>
  void visitWithin(const Aabb& box, const Visit& visit) const {
    look(0, order_.size(), 0, box, visit);
  }

 private:
  // Orders the points of [begin, end): the middle one is the median along the axis, points before
  // it are not greater there, and points after it not less.
  void halve(std::size_t begin, std::size_t end, int axis) {
    if (end - begin < 2) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [this](std::size_t i) {
      return order_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    std::nth_element(at(begin), at(middle), at(end),
                     [this, axis](std::uint32_t i, std::uint32_t j) {
                       return points_[i][axis] < points_[j][axis];
                     });
    halve(begin, middle, (axis + 1) % 3);
    halve(middle + 1, end, (axis + 1) % 3);
  }

  template <class Visit>
  void look(std::size_t begin, std::size_t end, int axis, const Aabb& box,
            const Visit& visit) const {
    if (begin == end) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const Vec3f& point = points_[order_[middle]];
    if (box.min[axis] <= point[axis]) look(begin, middle, (axis + 1) % 3, box, visit);
    if (intersects(box, {point, point})) visit(order_[middle]);
    if (point[axis] <= box.max[axis]) look(middle + 1, end, (axis + 1) % 3, box, visit);
  }

  std::vector<Vec3f> points_;
  std::vector<std::uint32_t> order_;
};

}  // namespace

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

namespace {

// The number of steps between two checks of the limit.
constexpr std::uint64_t kStepsALook = 1 << 12;

bool contains(const Aabb& outer, const Aabb& inner) {
  return intersects(outer, {inner.min, inner.min}) && intersects(outer, {inner.max, inner.max});
}

// A pair of components that touch, stored as body, component, body, component.
using Touch = std::array<std::uint32_t, 4>;

// Finds the components of one body that are within closed components of another.
class PairLook {
 public:
  // `touches`(component of inner, component of outer) tells whether two components touch.
  PairLook(PosedComponents& inner, const PosedComponents& outer, const CycleLimit& limit)
      : inner_(inner),
        outer_(outer),
        pace_(limit, kStepsALook),
        is_inside_(inner.components().count(), false) {}

  // Returns one entry per component of inner. Gives up if the limit is over.
  template <class Touches>
  const std::vector<bool>& find(const Touches& touches) {
    const MeshComponents& outer = outer_.components();
    if (!intersects(inner_.box(), outer_.box())) return is_inside_;
    for (std::uint32_t q = 0; q < outer.count() && !pace_.over(); ++q) {
      if (!outer.closed[q]) continue;
      choose(q, touches);
      if (!chosen_.empty()) countCrossings(q);
    }
    return is_inside_;
  }

 private:
  // Lists the components of inner that may be within this component of outer, and are not known to
  // be within another.
  template <class Touches>
  void choose(std::uint32_t q, const Touches& touches) {
    chosen_.clear();
    const Aabb& box = outer_.box(q);
    inner_.tree().visitWithin(box, [&](std::uint32_t c) {
      pace_.over();
      if (is_inside_[c] || !contains(box, inner_.box(c)) || touches(c, q)) return;
      chosen_.push_back(c);
    });
  }

  // Tests the chosen components. An upward ray can meet a triangle only if its point is within the
  // triangle's box extended down to infinity. If the limit ends the count early, nothing is known.
  void countCrossings(std::uint32_t q) {
    std::vector<Vec3f> points;
    points.reserve(chosen_.size());
    for (const std::uint32_t c : chosen_) points.push_back(inner_.point(c));
    const PointTree tree(points);
    const MeshComponents& outer = outer_.components();
    std::vector<std::uint32_t> odd(chosen_.size(), 0);  // a bit for each layer
    PredicateState state;
    for (std::uint32_t i = outer.first[q]; i < outer.first[q + 1]; ++i) {
      if (pace_.over()) return;
      const std::uint32_t layers = outer.layers[outer.triangles[i]];
      if (layers == 0) continue;
      const Triangle triangle = outer_.posed().triangle(outer.triangles[i]);
      Aabb beneath = boxOf(triangle);
      beneath.min.z = -INFINITY;
      tree.visitWithin(beneath, [&](std::uint32_t p) {
        if (!pace_.over() && crossesUpwards(points[p], triangle, state)) odd[p] ^= layers;
      });
    }
    if (pace_.over(0)) return;
    for (std::size_t p = 0; p < chosen_.size(); ++p) {
      if (odd[p] != 0) is_inside_[chosen_[p]] = true;
    }
  }

  PosedComponents& inner_;
  const PosedComponents& outer_;
  PacedLimit pace_;
  std::vector<bool> is_inside_;
  std::vector<std::uint32_t> chosen_;
};

// Returns the pairs of components that touch, sorted, each once, and each from both sides.
template <class ComponentOf>
std::vector<Touch> touchesOf(const DetectionResult& result, const ComponentOf& component_of) {
  std::vector<Touch> all;
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    const TrianglePair& pair = result.contacts[i];
    if (pair.body_a == pair.body_b || !result.touches(i)) continue;
    const Touch touch{pair.body_a, component_of(pair.body_a, pair.triangle_a), pair.body_b,
                      component_of(pair.body_b, pair.triangle_b)};
    // Contacts are sorted, so many of the same two components follow one another.
    if (!all.empty() && all.back() == touch) continue;
    all.push_back(touch);
  }
  const std::size_t one_sided = all.size();
  all.reserve(2 * one_sided);
  for (std::size_t i = 0; i < one_sided; ++i) {
    const Touch touch = all[i];
    all.push_back({touch[2], touch[3], touch[0], touch[1]});
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

ContainmentFinder::ContainmentFinder() = default;
ContainmentFinder::~ContainmentFinder() = default;

// Updates all bodies that are in an enabled pair of different bodies. Returns false if the limit is
// over.
bool ContainmentFinder::prepare(const Scene& scene, const CycleLimit& limit) {
  bodies_.resize(scene.bodyCount());
  for (const auto& [a, b] : scene.enabledPairs()) {
    if (a == b) continue;
    for (const BodyId id : {a, b}) {
      Containment::Components& of = containment_.bodies[id];
      if (std::exchange(of.looked_at, true)) continue;
      if (bodies_[id] == nullptr) bodies_[id] = std::make_unique<PosedComponents>();
      if (!bodies_[id]->update(scene.body(id), limit)) {
        of.looked_at = false;
        return false;
      }
      const std::vector<bool>& closed = bodies_[id]->components().closed;
      of.all = static_cast<std::uint32_t>(closed.size());
      of.open = static_cast<std::uint32_t>(std::count(closed.begin(), closed.end(), false));
    }
  }
  return true;
}

const Containment& ContainmentFinder::find(const Scene& scene, const DetectionResult& result,
                                           const CycleLimit& limit) {
  requireHostVertices(scene, "containment");
  containment_ = Containment();
  containment_.bodies.resize(scene.bodyCount());
  if (!prepare(scene, limit)) {
    containment_.cut_off_because = limit.why();
    return containment_;
  }
  const std::vector<Touch> touch = touchesOf(result, [this](BodyId id, std::uint32_t t) {
    return bodies_[id]->components().of_triangle[t];
  });
  // Lists the components of `inner` that are within `outer`.
  const auto look = [&](BodyId inner, BodyId outer) {
    PairLook pair(*bodies_[inner], *bodies_[outer], limit);
    const std::vector<bool>& is_inside = pair.find([&](std::uint32_t p, std::uint32_t q) {
      return std::binary_search(touch.begin(), touch.end(), Touch{inner, p, outer, q});
    });
    for (std::uint32_t c = 0; c < is_inside.size(); ++c) {
      if (!is_inside[c]) continue;
      const MeshComponents& of = bodies_[inner]->components();
      containment_.parts.push_back(
          {inner, outer, of.triangles[of.first[c]], bodies_[inner]->centroid(c)});
    }
  };
  for (const auto& [a, b] : scene.enabledPairs()) {
    if (limit.over()) break;
    if (a == b || !bodies_[a]->isFinitePosed() || !bodies_[b]->isFinitePosed()) continue;
    // Either body may have parts within the other.
    look(a, b);
    look(b, a);
  }
  if (limit.wasOver()) containment_.cut_off_because = limit.why();
  std::sort(containment_.parts.begin(), containment_.parts.end(),
            [](const InsidePart& a, const InsidePart& b) {
              return std::tie(a.inner, a.outer, a.triangle) <
                     std::tie(b.inner, b.outer, b.triangle);
            });
  return containment_;
}

}  // namespace deformable_contact_monitor
