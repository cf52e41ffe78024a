// A triangle spread over vector lanes: the CPU's form for the filters that most pairs end in.
#pragma once

#include "core/adjacency.h"
#include "core/plane_filter.h"
#include "core/triangle.h"

namespace deformable_contact_monitor {

using FloatLanes = float __attribute__((vector_size(16)));
using IntLanes = int __attribute__((vector_size(16)));

// One bit per lane of a mask.
inline int laneBits(const IntLanes& mask) {
#ifdef __SSE__
  return __builtin_ia32_movmskps(reinterpret_cast<const FloatLanes&>(mask));
#else
  return (mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8);
#endif
}

inline bool allLanes(const IntLanes& mask) { return laneBits(mask) == 15; }

// The fourth lane repeats the third vertex.
struct LaneTriangle {
  FloatLanes x, y, z;

  LaneTriangle() = default;
  explicit LaneTriangle(const Triangle& t)
      : x{t.v[0].x, t.v[1].x, t.v[2].x, t.v[2].x},
        y{t.v[0].y, t.v[1].y, t.v[2].y, t.v[2].y},
        z{t.v[0].z, t.v[1].z, t.v[2].z, t.v[2].z} {}
};

// Are all vertices certainly strictly on one side of the plane?
inline bool onOneSide(const PlaneFilter& plane, const LaneTriangle& t) {
  FloatLanes value, error;
  plane.distance(t.x, t.y, t.z, value, error);
  return (laneBits(value > error) == 15) | (laneBits(value < -error) == 15);
}

// As PlaneFilter::side, for the three vertices; true if all are on one side.
inline bool sidesOf(const PlaneFilter& plane, const LaneTriangle& t, int side[3]) {
  FloatLanes value, error;
  plane.distance(t.x, t.y, t.z, value, error);
  const int plus = laneBits(value > error), minus = laneBits(value < -error);
  for (int i = 0; i < 3; ++i) side[i] = (plus >> i & 1) - (minus >> i & 1);
  return (plus == 15) | (minus == 15);
}

inline bool shareVertex(const LaneTriangle& a, const LaneTriangle& b) {
  return laneBits(((b.x == a.x[0]) & (b.y == a.y[0]) & (b.z == a.z[0])) |
                  ((b.x == a.x[1]) & (b.y == a.y[1]) & (b.z == a.z[1])) |
                  ((b.x == a.x[2]) & (b.y == a.y[2]) & (b.z == a.z[2]))) != 0;
}

// Which vertices of two triangles are equal.
inline SharedVertices sharedVertices(const LaneTriangle& a, const LaneTriangle& b) {
  SharedVertices shared;
  const auto equalTo = [&](int i) { return (b.x == a.x[i]) & (b.y == a.y[i]) & (b.z == a.z[i]); };
  const IntLanes equal[3] = {equalTo(0), equalTo(1), equalTo(2)};
  const int in_b = laneBits(equal[0] | equal[1] | equal[2]);
  if (in_b == 0) return shared;
  shared.any = true;
  for (int i = 0; i < 3; ++i) {
    shared.in_a[i] = laneBits(equal[i]) != 0;
    shared.in_b[i] = (in_b >> i & 1) != 0;
  }
  return shared;
}

// Are the vertices that are not shared certainly all on one side of a plane through the shared
// ones? True also if there are none.
inline bool restOnOneSide(const PlaneFilter& plane, const LaneTriangle& t, const bool in_t[3]) {
  const IntLanes shared = {-in_t[0], -in_t[1], -in_t[2], -in_t[2]};
  FloatLanes value, error;
  plane.distance(t.x, t.y, t.z, value, error);
  return allLanes((value > error) | shared) || allLanes((value < -error) | shared);
}

}  // namespace deformable_contact_monitor
