// The verdict on one candidate pair.
#pragma once

#include "core/adjacency.h"
#include "core/plane_filter.h"
#include "core/triangle_distance.h"

namespace deformable_contact_monitor {

struct Verdict {
  bool contact = false;
  float separation_m = 0;  // 0: they intersect
};

// Two triangles that share no vertex, with what the plane filters said. `margin_m` is the larger of
// their bodies' margins.
DCM_HD inline Verdict separateVerdict(const Triangle& a, const Triangle& b, const KnownSides& sides,
                                      float margin_m, PredicateState& state) {
  if (trianglesIntersect(a, b, sides, state)) return {true, 0};
  if (margin_m == 0) return {};
  const double distance = separation(a, b);
  return {distance <= margin_m, static_cast<float>(distance)};
}

// Two triangles of one body that share vertices. Margins do not apply: neighbours in a mesh are
// always near.
DCM_HD inline Verdict adjacentVerdict(const Triangle& a, const PlaneFilter& plane_a,
                                      const Triangle& b, const PlaneFilter& plane_b,
                                      const SharedVertices& shared, PredicateState& state) {
  // With one common vertex, two others strictly on one side of a plane through it settle it.
  int side_a = 0, side_b = 0, rest_a = 0, rest_b = 0;
  for (int i = 0; i < 3; ++i) {
    if (!shared.in_a[i]) {
      side_a += plane_b.side(a.v[i]);
      ++rest_a;
    }
    if (!shared.in_b[i]) {
      side_b += plane_a.side(b.v[i]);
      ++rest_b;
    }
  }
  if (rest_a == 0 || rest_b == 0) return {};
  if (side_a == rest_a || side_a == -rest_a || side_b == rest_b || side_b == -rest_b) return {};
  return {meetBeyondShared(a, b, shared, state), 0};
}

// A pair as received (not posed otherwise), by the scalar filters; `same_body`: equal vertices are
// shared.
DCM_HD inline Verdict pairVerdict(const Triangle& a, const Triangle& b, bool same_body,
                                  AdjacentPairs adjacent, float margin_m, PredicateState& state) {
  const PlaneFilter plane_a(a), plane_b(b);
  const SharedVertices shared = same_body ? sharedVertices(a, b) : SharedVertices();
  if (shared.any) {
    if (adjacent == AdjacentPairs::kSkip) return {};
    return adjacentVerdict(a, plane_a, b, plane_b, shared, state);
  }
  KnownSides sides;
  for (int i = 0; i < 3; ++i) {
    sides.a[i] = plane_b.side(a.v[i]);
    sides.b[i] = plane_a.side(b.v[i]);
  }
  return separateVerdict(a, b, sides, margin_m, state);
}

}  // namespace deformable_contact_monitor
