// Recentred, scaled coordinates for clustering and projection only. Verdicts never use them.
#pragma once

#include "core/host_device.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// v -> (v - origin) * scale, scale a power of two that brings the working set into [-1, 1]. In
// double: the scale of a subnormal scene is no float32.
struct SceneScale {
  Vec3d origin;
  double scale = 1;

  DCM_HD Vec3d applyExact(const Vec3d& v) const { return (v - origin) * scale; }
  // Each coordinate of the result is off by less than kScaledError times its own size.
  DCM_HD Vec3f apply(const Vec3f& v) const { return toFloat(applyExact(toDouble(v))); }
  DCM_HD Vec3d invert(const Vec3f& s) const { return toDouble(s) * (1 / scale) + origin; }
};

// 2^-24 for the rounding to float32, and slack for the one in double.
constexpr float kScaledError = 6.0e-8F;

}  // namespace deformable_contact_monitor
