// Conservative intervals of triangles along axes, and their packed form for the sweep.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/host_device.h"
#include "core/rules/scene_scale.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

struct Interval {
  float lo, hi;
};

// The interval of a scaled triangle along a stored axis, or of all points that a moving one has at
// both ends of a step; grown by the margin and by all that rounding can have moved: the exact
// projections of the unrounded points lie inside.
template <int kPoints = 3>
DCM_HD inline Interval project(const Vec3f& axis, const Vec3f v[kPoints], float margin) {
  float lo = dot(axis, v[0]), hi = lo;
  float mx = fabsf(v[0].x), my = fabsf(v[0].y), mz = fabsf(v[0].z);
  for (int k = 1; k < kPoints; ++k) {
    const float p = dot(axis, v[k]);
    lo = least(lo, p);
    hi = most(hi, p);
    mx = most(mx, fabsf(v[k].x));
    my = most(my, fabsf(v[k].y));
    mz = most(mz, fabsf(v[k].z));
  }
  // u = 2^-24: 1 for the scaled coordinate, 3 for the dot product, 1 for the sum below, slack.
  constexpr float kError = 6 * kScaledError;
  const float pad =
      (fabsf(axis.x) * mx + fabsf(axis.y) * my + fabsf(axis.z) * mz) * kError + margin + 1e-44F;
  return {lo - pad, hi + pad};
}

// Two intervals on 15 bits each, in the two halves of a word; the top bit of each half is spare. A
// monotone map keeps lo <= hi, so nothing that overlaps is lost.
struct PackedBox {
  std::uint32_t lo, hi;
};

constexpr std::uint32_t kPackedGuard = 0x80008000U;

struct Quantiser {
  float origin = 0, scale = 0;

  Quantiser() = default;
  DCM_HD Quantiser(float lo, float hi) : origin(lo), scale(32767.0F / (hi - lo)) {
    if (!(scale < 1e37F)) scale = 0;
  }
  DCM_HD std::uint32_t operator()(float x) const {
    return static_cast<std::uint32_t>(least(most((x - origin) * scale, 0.0F), 32767.0F));
  }
};

DCM_HD inline PackedBox pack(const Quantiser q[2], const Interval i[2]) {
  return {q[0](i[0].lo) | q[1](i[1].lo) << 16, q[0](i[0].hi) | q[1](i[1].hi) << 16};
}

// Closed intersection on both axes: no half borrows from its guard bit.
DCM_HD inline bool intersects(const PackedBox& a, const PackedBox& b) {
  return (((a.hi | kPackedGuard) - b.lo) & ((b.hi | kPackedGuard) - a.lo) & kPackedGuard) ==
         kPackedGuard;
}

// As areApart(MovingBox, MovingBox) is for boxes: a packed box of each end of the step.
struct MovingPackedBox {
  PackedBox from, to;
};

DCM_HD inline bool intersects(const MovingPackedBox& a, const MovingPackedBox& b) {
  const std::uint32_t above =
      ((a.from.hi | kPackedGuard) - b.from.lo) | ((a.to.hi | kPackedGuard) - b.to.lo);
  const std::uint32_t below =
      ((b.from.hi | kPackedGuard) - a.from.lo) | ((b.to.hi | kPackedGuard) - a.to.lo);
  return (above & below & kPackedGuard) == kPackedGuard;
}

}  // namespace deformable_contact_monitor
