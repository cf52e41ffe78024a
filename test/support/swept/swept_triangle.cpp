// A triangle of a scene in two states, for the swept oracle.
#include "swept_triangle.h"

#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "core/rules/posed_vertex.h"

namespace deformable_contact_monitor {
namespace {

RationalPoint toRational(const Vec3f& v) {
  return {mpq_class(double{v.x}), mpq_class(double{v.y}), mpq_class(double{v.z})};
}

// Points of both hulls, each once.
class PointList {
 public:
  PointSet add(const SweptTriangle& t) {
    PointSet set = 0;
    for (int i = 0; i < 3; ++i) {
      const Key key{t.body, t.received[0].v[i], t.received[1].v[i]};
      const auto place = std::find(keys_.begin(), keys_.end(), key);
      set |= only(static_cast<int>(place - keys_.begin()));
      if (place != keys_.end()) continue;
      keys_.push_back(key);
      points_.push_back({toRational(t.posed[0].v[i]), toRational(t.posed[1].v[i])});
    }
    return set;
  }

  const std::vector<Trajectory>& points() const { return points_; }

 private:
  using Key = std::tuple<BodyId, Vec3f, Vec3f>;
  std::vector<Key> keys_;
  std::vector<Trajectory> points_;
};

bool shareAVertex(const SweptTriangle& a, const SweptTriangle& b) {
  if (a.body != b.body) return false;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (a.received[0].v[i] == b.received[0].v[j] && a.received[1].v[i] == b.received[1].v[j]) {
        return true;
      }
    }
  }
  return false;
}

Triangle received(const Body& body, std::uint32_t triangle) {
  Triangle t;
  for (int i = 0; i < 3; ++i) t.v[i] = body.mesh.vertex(body.mesh.triangles[3 * triangle + i]);
  return t;
}

Triangle posed(const Body& body, const Triangle& t) {
  Triangle out;
  for (int i = 0; i < 3; ++i) out.v[i] = posedVertex(body.pose, body.pose.isIdentity(), t.v[i]);
  return out;
}

}  // namespace

bool isFinite(const SweptTriangle& t) { return isFinite(t.posed[0]) && isFinite(t.posed[1]); }

MovingHulls hullsOf(const SweptTriangle& a, const SweptTriangle& b) {
  PointList list;
  MovingHulls hulls;
  hulls.a = list.add(a);
  hulls.b = list.add(b);
  hulls.points = list.points();
  return hulls;
}

bool isJudged(const SweptTriangle& a, const SweptTriangle& b, AdjacentPairs adjacent) {
  return isFinite(a) && isFinite(b) &&
         (adjacent == AdjacentPairs::kBeyondShared || !shareAVertex(a, b));
}

std::vector<SweptTriangle> sweptTriangles(const Scene& state0, const Scene& state1) {
  std::vector<SweptTriangle> out;
  for (BodyId b = 0; b < state1.bodyCount(); ++b) {
    const Body& before = state0.body(b);
    const Body& after = state1.body(b);
    for (std::uint32_t t = 0; t < after.mesh.triangleCount(); ++t) {
      SweptTriangle item{b, t, {received(before, t), received(after, t)}, {}};
      item.posed = {posed(before, item.received[0]), posed(after, item.received[1])};
      if (isFinite(item)) out.push_back(item);
    }
  }
  return out;
}

std::vector<std::pair<const SweptTriangle*, const SweptTriangle*>> sweptBoxPairs(
    const Scene& scene, const std::vector<SweptTriangle>& triangles, AdjacentPairs adjacent) {
  using Box = CGAL::Box_intersection_d::Box_with_handle_d<double, 3, const SweptTriangle*>;
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (const SweptTriangle& t : triangles) {
    double low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
      const Triangle &p = t.posed[0], &q = t.posed[1];
      const auto range = std::minmax({p.v[0][axis], p.v[1][axis], p.v[2][axis],  //
                                      q.v[0][axis], q.v[1][axis], q.v[2][axis]});
      low[axis] = range.first;
      high[axis] = range.second;
    }
    boxes.emplace_back(low, high, &t);
  }
  std::vector<std::pair<const SweptTriangle*, const SweptTriangle*>> pairs;
  CGAL::box_self_intersection_d(
      boxes.begin(), boxes.end(),
      [&](const Box& a, const Box& b) {
        const SweptTriangle *first = a.handle(), *second = b.handle();
        if (!scene.pairEnabled(first->body, second->body)) return;
        if (!isJudged(*first, *second, adjacent)) return;
        pairs.push_back(std::minmax(first, second));  // they lie in this order
      },
      std::ptrdiff_t{10}, CGAL::Box_intersection_d::CLOSED);
  return pairs;
}

}  // namespace deformable_contact_monitor
