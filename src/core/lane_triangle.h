// A triangle spread over vector lanes: the CPU's form for the filters that most pairs end in.
#pragma once

#include "core/adjacency.h"
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

// Which vertices of two triangles are equal, as lane masks (-1 where true).
struct SharedLanes {
  IntLanes in_a = {0, 0, 0, 0}, in_b = {0, 0, 0, 0};
  bool any = false;

  explicit SharedLanes(const SharedVertices& v)
      : in_a{-v.in_a[0], -v.in_a[1], -v.in_a[2], -v.in_a[2]},
        in_b{-v.in_b[0], -v.in_b[1], -v.in_b[2], -v.in_b[2]},
        any(v.any) {}
  SharedLanes(const LaneTriangle& a, const LaneTriangle& b) {
    for (int i = 0; i < 3; ++i) {
      const IntLanes equal = (b.x == a.x[i]) & (b.y == a.y[i]) & (b.z == a.z[i]);
      in_b |= equal;
      if (anyLane(equal)) {
        any = true;
        in_a[i] = -1;
      }
    }
    in_a[3] = in_a[2];
  }

  SharedVertices vertices() const {
    return {{in_a[0] != 0, in_a[1] != 0, in_a[2] != 0},
            {in_b[0] != 0, in_b[1] != 0, in_b[2] != 0},
            any};
  }
};

// Are the vertices that are not shared certainly all on one side of a plane through the shared
// ones? True also if there are none.
inline bool restOnOneSide(const PlaneFilter& plane, const LaneTriangle& t, const IntLanes& shared) {
  FloatLanes value, error;
  plane.distance(t.x, t.y, t.z, value, error);
  return allLanes((value > error) | shared) || allLanes((value < -error) | shared);
}

}  // namespace deformable_contact_monitor
