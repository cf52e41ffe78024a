// The first, float32 filter of the narrow phase: is a triangle certainly on one side of another's
// plane?
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// The plane of a triangle: its normal and what bounds the rounding error of distances from it.
struct PlaneFilter {
  Vec3f origin, normal, permanent;

  PlaneFilter() = default;
  DCM_HD explicit PlaneFilter(const Triangle& t) : origin(t.v[0]) {
    const Vec3f u = t.v[1] - t.v[0], w = t.v[2] - t.v[0];
    const float m1 = u.y * w.z, m2 = u.z * w.y, m3 = u.z * w.x;
    const float m4 = u.x * w.z, m5 = u.x * w.y, m6 = u.y * w.x;
    normal = {m1 - m2, m3 - m4, m5 - m6};
    // The constant covers products that underflow.
    permanent = {fabsf(m1) + fabsf(m2) + 1e-37F, fabsf(m3) + fabsf(m4) + 1e-37F,
                 fabsf(m5) + fabsf(m6) + 1e-37F};
  }

  // How far p is from the plane, and by how much that may be wrong; in units of the normal. Real is
  // float, or a vector of floats: then for several points at once.
  template <class Real>
  DCM_HD void distance(const Real& x, const Real& y, const Real& z, Real& value,
                       Real& error) const {
    const Real dx = x - origin.x, dy = y - origin.y, dz = z - origin.z;
    value = normal.x * dx + normal.y * dy + normal.z * dz;
    constexpr float kBound =
        4.3e-7F;  // (7 + 56 u) u, u = 2^-24, Shewchuk's for orient3d, and slack
    error = kBound * (permanent.x * most(dx, -dx) + permanent.y * most(dy, -dy) +
                      permanent.z * most(dz, -dz)) +
            1e-36F;
  }

  // 1 or -1: certainly strictly on that side; 0: undecided, also after overflow.
  DCM_HD int side(const Vec3f& p) const {
    float value, error;
    distance(p.x, p.y, p.z, value, error);
    return (value > error) - (value < -error);
  }
};

}  // namespace deformable_contact_monitor
