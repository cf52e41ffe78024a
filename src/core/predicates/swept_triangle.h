// Points and triangles that move on straight lines from one state (t = 0) to the next (t = 1), and
// boxes that move with them.
#pragma once

#include "core/predicates/aabb.h"
#include "core/predicates/adjacency.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// A point that is at from + t (to - from) at time t in [0, 1], in real numbers.
struct MovingPoint {
  Vec3f from, to;
};

DCM_HD inline bool operator==(const MovingPoint& a, const MovingPoint& b) {
  return a.from == b.from && a.to == b.to;
}

DCM_HD inline bool isFinite(const MovingPoint& p) { return isFinite(p.from) && isFinite(p.to); }

struct MovingTriangle {
  Triangle from, to;

  DCM_HD MovingPoint point(int i) const { return {from.v[i], to.v[i]}; }
};

// Triangles that are not finite take no part in continuous detection.
DCM_HD inline bool isFinite(const MovingTriangle& t) { return isFinite(t.from) && isFinite(t.to); }

// Returns whether the triangle does not move.
DCM_HD inline bool isStill(const MovingTriangle& t) {
  return t.from.v[0] == t.to.v[0] && t.from.v[1] == t.to.v[1] && t.from.v[2] == t.to.v[2];
}

// Finds the shared vertices by equal coordinates as received, in both states. Points that coincide
// in one state only are two points.
DCM_HD inline SharedVertices sharedTrajectories(const MovingTriangle& a, const MovingTriangle& b) {
  SharedVertices shared;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (a.point(i) == b.point(j)) shared.in_a[i] = shared.in_b[j] = shared.any = true;
    }
  }
  return shared;
}

// A box that moves: at each time its content lies in the box that is interpolated between the two.
struct MovingBox {
  Aabb from, to;

  DCM_HD void include(const MovingPoint& p) {
    from.include(p.from);
    to.include(p.to);
  }
  DCM_HD void include(const MovingBox& box) {
    from.include(box.from);
    to.include(box.to);
  }
};

DCM_HD inline MovingBox boxOf(const MovingTriangle& t) { return {boxOf(t.from), boxOf(t.to)}; }

// Returns the box grown by `distance` >= 0 [m] at all times.
DCM_HD inline MovingBox inflated(const MovingBox& box, float distance) {
  return {inflated(box.from, distance), inflated(box.to, distance)};
}

// Returns the box of all points that the content passes.
DCM_HD inline Aabb sweptBox(const MovingBox& box) {
  Aabb all = box.from;
  all.include(box.to);
  return all;
}

// Returns whether, along some axis, a is strictly below b at both ends of the interval, or above it
// at both. Then they are so at all times, because differences of coordinates are linear in time. It
// only compares. If a bound is infinite or NaN, the answer is false. It uses & instead of && as
// intersects() does.
DCM_HD inline bool areApart(const MovingBox& a, const MovingBox& b) {
  return ((a.from.max.x < b.from.min.x) & (a.to.max.x < b.to.min.x)) |
         ((b.from.max.x < a.from.min.x) & (b.to.max.x < a.to.min.x)) |
         ((a.from.max.y < b.from.min.y) & (a.to.max.y < b.to.min.y)) |
         ((b.from.max.y < a.from.min.y) & (b.to.max.y < a.to.min.y)) |
         ((a.from.max.z < b.from.min.z) & (a.to.max.z < b.to.min.z)) |
         ((b.from.max.z < a.from.min.z) & (b.to.max.z < a.to.min.z));
}

// Returns whether they may intersect at some time, as far as these comparisons can tell.
DCM_HD inline bool intersects(const MovingBox& a, const MovingBox& b) { return !areApart(a, b); }

}  // namespace deformable_contact_monitor
