// A moving box spread over vector lanes: the CPU's form for the test that ends most pairs' sweep.
#pragma once

#include "core/cpu/lane_triangle.h"
#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

// The fourth lane is 0 throughout.
struct LaneMovingBox {
  FloatLanes from_min, from_max, to_min, to_max;

  LaneMovingBox() = default;
  // The same in another form.
  LaneMovingBox(const MovingBox& box)  // NOLINT(google-explicit-constructor)
      : from_min(lanes(box.from.min)),
        from_max(lanes(box.from.max)),
        to_min(lanes(box.to.min)),
        to_max(lanes(box.to.max)) {}

 private:
  static FloatLanes lanes(const Vec3f& v) { return FloatLanes{v.x, v.y, v.z, 0}; }
};

// As of MovingBox.
inline bool intersects(const LaneMovingBox& a, const LaneMovingBox& b) {
  const IntLanes below = (a.from_max < b.from_min) & (a.to_max < b.to_min);
  const IntLanes above = (b.from_max < a.from_min) & (b.to_max < a.to_min);
  return laneBits(below | above) == 0;
}

}  // namespace deformable_contact_monitor
