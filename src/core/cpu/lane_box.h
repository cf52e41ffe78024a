// Boxes in vector lanes: the form in which the CPU compares the boxes of many pairs.
#pragma once

#include "core/cpu/lane_triangle.h"
#include "core/predicates/aabb.h"
#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

inline FloatLanes laneCorner(const Vec3f& v) { return FloatLanes{v.x, v.y, v.z, 0}; }

// A box with finite corners. The fourth lane is 0 throughout this file.
struct LaneBox {
  FloatLanes min, max;

  LaneBox() = default;
  // The same in another form.
  LaneBox(const Aabb& box)  // NOLINT(google-explicit-constructor)
      : min(laneCorner(box.min)), max(laneCorner(box.max)) {}
};

// Returns whether two closed boxes intersect, as for Aabb.
inline bool intersects(const LaneBox& a, const LaneBox& b) {
  return laneBits((a.max < b.min) | (b.max < a.min)) == 0;
}

// Returns the box of a triangle, grown by growth_m >= 0 [m].
inline LaneBox boxLanes(const Triangle& t, float growth_m) {
  if (growth_m > 0) return inflated(boxOf(t), growth_m);
  const FloatLanes a = laneCorner(t.v[0]), b = laneCorner(t.v[1]), c = laneCorner(t.v[2]);
  LaneBox box;
  box.min = least(least(a, b), c);
  box.max = most(most(a, b), c);
  return box;
}

// A moving box: its corners at both ends of the time interval.
struct LaneMovingBox {
  FloatLanes from_min, from_max, to_min, to_max;

  LaneMovingBox() = default;
  // The same in another form.
  LaneMovingBox(const MovingBox& box)  // NOLINT(google-explicit-constructor)
      : from_min(laneCorner(box.from.min)),
        from_max(laneCorner(box.from.max)),
        to_min(laneCorner(box.to.min)),
        to_max(laneCorner(box.to.max)) {}
};

inline LaneMovingBox boxLanes(const MovingTriangle& t, float growth_m) {
  return inflated(boxOf(t), growth_m);
}

// Returns whether two moving boxes may intersect, as for MovingBox.
inline bool intersects(const LaneMovingBox& a, const LaneMovingBox& b) {
  const IntLanes below = (a.from_max < b.from_min) & (a.to_max < b.to_min);
  const IntLanes above = (b.from_max < a.from_min) & (b.to_max < a.to_min);
  return laneBits(below | above) == 0;
}

}  // namespace deformable_contact_monitor
