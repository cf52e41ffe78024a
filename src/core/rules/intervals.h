// Conservative intervals of triangles along axes, their quantised form for the sweep, and sort
// keys.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/host_device.h"
#include "core/rules/scene_scale.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Returns an unsigned integer that orders as the floats do; -0 comes before 0. x must not be NaN.
DCM_HD inline std::uint32_t orderedBits(float x) {
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

DCM_HD inline float fromOrderedBits(std::uint32_t ordered) {
  const std::uint32_t bits = (ordered & 0x80000000U) != 0 ? ordered ^ 0x80000000U : ~ordered;
  float x;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

struct Interval {
  float lo, hi;
};

// Returns the interval of a scaled triangle along an axis, or of all points that a moving one has
// at both ends of the time interval. It is grown by the margin and by all that rounding can have
// moved: the exact projections of the unrounded points lie inside.
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

// Two intervals with 15 bits each, in the two halves of a word. The top bit of each half is a guard
// bit: it is set in `hi` and not in `lo`. The map is monotone, so that lo <= hi still holds, and no
// overlap is lost.
struct PackedBox {
  std::uint32_t lo, hi;
};

constexpr std::uint32_t kPackedGuard = 0x80008000U;

// Maps an interval of floats monotonically to 15 bits.
struct Quantiser {
  float origin = 0, scale = 0;

  Quantiser() = default;
  DCM_HD Quantiser(float lo, float hi) : origin(lo), scale(32767.0F / (hi - lo)) {
    if (!(scale < 1e37F)) scale = 0;
  }
  // Returns the one for all within `reach` of `middle`, as far as a range has a length in float32.
  static Quantiser around(double middle, double reach) {
    const auto bound = [](double x) { return static_cast<float>(least(most(x, -1e38), 1e38)); };
    return {bound(middle - reach), bound(middle + reach)};
  }
  DCM_HD std::uint32_t operator()(float x) const {
    // The sum is rounded to an integer, which its last bits hold. That is cheaper than a
    // conversion.
    const float sum = least(most((x - origin) * scale, 0.0F), 32767.0F) + 8388608.0F;
    std::uint32_t bits;
    std::memcpy(&bits, &sum, sizeof bits);
    return bits & 0xffff;
  }
};

DCM_HD inline PackedBox pack(const Quantiser q[2], const Interval i[2]) {
  return {q[0](i[0].lo) | q[1](i[1].lo) << 16, q[0](i[0].hi) | q[1](i[1].hi) << 16 | kPackedGuard};
}

// Returns whether the boxes intersect on both axes; touching counts. No half borrows from its guard
// bit.
DCM_HD inline bool intersects(const PackedBox& a, const PackedBox& b) {
  return ((a.hi - b.lo) & (b.hi - a.lo) & kPackedGuard) == kPackedGuard;
}

// Quantised boxes at both ends of the time interval. They are apart as moving boxes are: on the
// same side at both ends.
struct MovingPackedBox {
  PackedBox from, to;
};

DCM_HD inline bool intersects(const MovingPackedBox& a, const MovingPackedBox& b) {
  const std::uint32_t above = (a.from.hi - b.from.lo) | (a.to.hi - b.to.lo);
  const std::uint32_t below = (b.from.hi - a.from.lo) | (b.to.hi - a.to.lo);
  return (above & below & kPackedGuard) == kPackedGuard;
}

}  // namespace deformable_contact_monitor
