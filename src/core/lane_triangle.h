// A triangle spread over vector lanes: the CPU's form for the filters that most pairs end in.
#pragma once

#include "core/plane_filter.h"
#include "core/triangle.h"

namespace deformable_contact_monitor {

using FloatLanes = float __attribute__((vector_size(16)));
using IntLanes = int __attribute__((vector_size(16)));

inline bool allLanes(const IntLanes& mask) { return (mask[0] & mask[1] & mask[2] & mask[3]) != 0; }
inline bool anyLane(const IntLanes& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }

// The fourth lane repeats the third vertex.
struct LaneTriangle {
  FloatLanes x, y, z;

  LaneTriangle() = default;
  explicit LaneTriangle(const Triangle& t)
      : x{t.v[0].x, t.v[1].x, t.v[2].x, t.v[2].x},
        y{t.v[0].y, t.v[1].y, t.v[2].y, t.v[2].y},
        z{t.v[0].z, t.v[1].z, t.v[2].z, t.v[2].z} {}
};

// As PlaneFilter::side, for the three vertices; true if all are certainly on one side.
inline bool onOneSide(const PlaneFilter& plane, const LaneTriangle& t, int side[3]) {
  FloatLanes value, error;
  plane.distance(t.x, t.y, t.z, value, error);
  const IntLanes above = value > error, below = value < -error;  // -1 where true
  if (allLanes(above) || allLanes(below)) return true;
  const IntLanes sides = below - above;
  for (int i = 0; i < 3; ++i) side[i] = sides[i];
  return false;
}

// Whether some vertices are equal.
inline bool shareVertex(const LaneTriangle& a, const LaneTriangle& b) {
  IntLanes equal = {0, 0, 0, 0};
  for (int i = 0; i < 3; ++i) {
    equal |= (b.x == a.x[i]) & (b.y == a.y[i]) & (b.z == a.z[i]);
  }
  return anyLane(equal);
}

}  // namespace deformable_contact_monitor
