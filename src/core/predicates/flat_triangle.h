// Decides triangles by their projections along a coordinate axis, in float32: where it decides, it
// is certain.
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/predicates/orientation.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// The answer of a part of the test; kOpen: it cannot tell.
enum class PartVerdict { kApart, kMeet, kOpen };

namespace detail {

DCM_HD inline bool isStrict(int sign) { return sign == 1 || sign == -1; }

struct FlatPoint {
  float x, y;

  DCM_HD FlatPoint(const Vec3f& p, int axis) { projected(p, axis, x, y); }
};

// Returns 1 or -1 if c is certainly strictly on that side of the line from a to b, in float32, and
// kUncertain if that is open, as it is after an overflow.
DCM_HD inline int certainTurn(const FlatPoint& a, const FlatPoint& b, const FlatPoint& c) {
  const float left = (b.x - a.x) * (c.y - a.y), right = (b.y - a.y) * (c.x - a.x);
  constexpr float kBound = 1.8e-7F;  // (3 + 16 u) u, u = 2^-24, Shewchuk's for orient2d, and slack
  constexpr float kUnderflow = 1e-37F;
  const float det = left - right, bound = kBound * (fabsf(left) + fabsf(right)) + kUnderflow;
  if (det > bound) return 1;
  return det < -bound ? -1 : kUncertain;
}

// Does the same with longer code, which tells exact turns too: 0 if c is certainly on the line. If
// float32 holds the differences exactly, rounded products that differ have the order of the true
// ones. Products of usual size are equal iff they are so rounded and in their errors.
DCM_HD inline int exactTurn(const FlatPoint& a, const FlatPoint& b, const FlatPoint& c) {
  const int turn = certainTurn(a, b, c);
  if (isStrict(turn)) return turn;
  ErrorFree<float> check;
  const float ux = check.difference(b.x, a.x), vy = check.difference(c.y, a.y);
  const float uy = check.difference(b.y, a.y), vx = check.difference(c.x, a.x);
  if (!check.exact) return kUncertain;
  const float left = ux * vy, right = uy * vx;
  if (left != right) return left > right ? 1 : -1;
  if ((ux == 0 || vy == 0) && (uy == 0 || vx == 0)) return 0;
  constexpr float kLeast = 1e-30F, kMost = 1e38F;  // between, float32 holds the error of a product
  const bool has_errors = fabsf(left) > kLeast && fabsf(left) < kMost;
  return has_errors && fmaf(ux, vy, -left) == fmaf(uy, vx, -right) ? 0 : kUncertain;
}

struct FlatTriangle {
  FlatPoint v[3];

  DCM_HD FlatTriangle(const Triangle& t, int axis)
      : v{{t.v[0], axis}, {t.v[1], axis}, {t.v[2], axis}} {}
};

// Tests the lines of t's edges: kApart if one certainly has all of the other triangle strictly on
// its outer side, kMeet if each certainly has a vertex of it on the line or on its inner side, else
// kOpen.
template <class Turn>
DCM_HD inline PartVerdict edgeLinesVerdict(FlatTriangle t, const FlatTriangle& other,
                                           const Turn& turn) {
  const int inner = turn(t.v[0], t.v[1], t.v[2]);
  if (!isStrict(inner)) return PartVerdict::kOpen;
  bool each_reached = true;
  DCM_ROLLED for (int edge = 0; edge < 3; ++edge) {
    bool all_outside = true, reached = false;
    for (int i = 0; i < 3; ++i) {
      const int side = turn(t.v[0], t.v[1], other.v[i]);
      all_outside = all_outside && side == -inner;
      reached = reached || side == inner || side == 0;
    }
    if (all_outside) return PartVerdict::kApart;
    each_reached = each_reached && reached;
    const FlatPoint first = t.v[0];
    t.v[0] = t.v[1];
    t.v[1] = t.v[2];
    t.v[2] = first;
  }
  return each_reached ? PartVerdict::kMeet : PartVerdict::kOpen;
}

}  // namespace detail

// Two triangles that share no vertex: do their projections along `axis` certainly not meet, or
// certainly meet? Two triangles with area in a plane are disjoint iff the line of an edge of one
// has the other strictly on its outer side, because the edges of their Minkowski difference are
// parallel to theirs. `turn` is one of the above.
template <class Turn>
DCM_HD inline PartVerdict projectedVerdict(const Triangle& a, const Triangle& b, int axis,
                                           const Turn& turn) {
  const detail::FlatTriangle flat_a(a, axis), flat_b(b, axis);
  const PartVerdict of_a = detail::edgeLinesVerdict(flat_a, flat_b, turn);
  if (of_a == PartVerdict::kApart) return of_a;
  const PartVerdict of_b = detail::edgeLinesVerdict(flat_b, flat_a, turn);
  return of_b == PartVerdict::kMeet ? of_a : of_b;
}

}  // namespace deformable_contact_monitor
