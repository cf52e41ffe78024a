// Decides for all triangles around a vertex at once: do any two of them meet beyond what they
// share?
#pragma once

#include <cstdint>

#include "core/host_device.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// A bit in a vertex's id: its fan is certified, see isFanCertified().
constexpr std::uint32_t kFanCertified = std::uint32_t{1} << 31;

namespace detail {

// Float32 cross products of edges that leave the same point.
struct EdgeProduct {
  Vec3f value, permanent;

  DCM_HD EdgeProduct(const Vec3f& u, const Vec3f& w) {
    const float m1 = u.y * w.z, m2 = u.z * w.y, m3 = u.z * w.x;
    const float m4 = u.x * w.z, m5 = u.x * w.y, m6 = u.y * w.x;
    value = {m1 - m2, m3 - m4, m5 - m6};
    // The constant covers products that underflow.
    permanent = {fabsf(m1) + fabsf(m2) + 1e-37F, fabsf(m3) + fabsf(m4) + 1e-37F,
                 fabsf(m5) + fabsf(m6) + 1e-37F};
  }

  // Returns 1 if the turn from u to w, seen against `normal`, is certainly to the left, -1 if to
  // the right, 0 if it is not certain or has overflowed. The error bound is that of PlaneFilter,
  // which has one rounding more.
  DCM_HD int turn(const Vec3f& normal) const {
    constexpr float kBound = 4.3e-7F;
    const float seen = dot(normal, value);
    const float error = kBound * (permanent.x * fabsf(normal.x) + permanent.y * fabsf(normal.y) +
                                  permanent.z * fabsf(normal.z)) +
                        1e-36F;
    return (seen > error) - (seen < -error);
  }
};

}  // namespace detail

// Certifies a vertex's fan: returns true if some projection onto a plane certainly shows its
// triangles side by side. That is the case if each of them turns left about the vertex, and
// together they turn at most once. Then they meet in the vertex and in the edges that they share,
// and nowhere else.
//
// Fan has size(), the number of ring points; ring(k), transformed: triangle k has the centre and
// the ring points k and k + 1; and closed(), whether the last ring point is the first one. A
// certified fan is certain for any input. The projection is along the triangles' mean normal.
template <class Fan>
DCM_HD inline bool isFanCertified(const Vec3f& centre, const Fan& fan) {
  const std::uint32_t size = fan.size();
  if (size < 2) return false;
  const Vec3f first = fan.ring(0) - centre;
  Vec3f normal, from = first;
  DCM_ROLLED for (std::uint32_t k = 1; k < size; ++k) {
    const Vec3f to = fan.ring(k) - centre;
    normal = normal + detail::EdgeProduct(from, to).value;
    from = to;
  }
  const float scale = most(most(fabsf(normal.x), fabsf(normal.y)), fabsf(normal.z));
  normal = normal * (1 / scale);
  // If the triangles turn by more than a full circle, they pass the first ray: some triangle that
  // starts on the right of it, or opposite to it, ends on it or on the left. The last triangle of a
  // closed fan may end on it. There are no branches, because few fans fail, and on the
  // device a warp waits for its longest.
  const std::uint32_t last = fan.closed() ? size - 1 : size;
  bool certified = true, was_ahead = false;
  from = first;
  DCM_ROLLED for (std::uint32_t k = 1; k < size; ++k) {
    const Vec3f to = fan.ring(k) - centre;
    certified &= detail::EdgeProduct(from, to).turn(normal) == 1;
    const int side = detail::EdgeProduct(first, to).turn(normal);
    certified &= (k >= last) | (k == 1) | was_ahead | (side == -1);
    was_ahead = side == 1;
    from = to;
  }
  return certified;
}

}  // namespace deformable_contact_monitor
