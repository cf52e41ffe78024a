// Points of edges, constructed: where a linear function that is known at both ends is zero.
//
// Coordinates are doubles of a quotient of determinants, and where too much would cancel, as with
// an edge that reaches from -1e30 to 1e30, their numerators are summed up exactly.
#pragma once

#include <cfloat>
#include <cmath>

#include "core/host_device.h"
#include "core/predicates/orientation.h"
#include "core/predicates/triangle.h"
#include "core/predicates/triangle_distance.h"

namespace deformable_contact_monitor {

// Never infinite: what rounding puts beyond the largest float32 comes back.
DCM_HD inline Vec3f nearestFloats(const Vec3d& v) {
  const auto nearest = [](double x) {
    return static_cast<float>(least<double>(most<double>(x, -FLT_MAX), FLT_MAX));
  };
  return {nearest(v.x), nearest(v.y), nearest(v.z)};
}

DCM_HD inline double largestCoordinate(const Vec3d& v) {
  return most(fabs(v.x), most(fabs(v.y), fabs(v.z)));
}

namespace detail {

// The zero of a linear function with the given values at p and q, each coordinate right to a part
// in 2^50.
template <int N>
DCM_HD DCM_RARE inline Vec3d exactZeroBetween(const Vec3f& p, const Vec3f& q,
                                              const Expansion<N>& at_p, const Expansion<N>& at_q) {
  const double divisor = at_q.value() - at_p.value();  // their signs differ
  double x[3];
  DCM_ROLLED for (int k = 0; k < 3; ++k) {
    Expansion<4 * N> sum;
    sum.addMultiple(at_q, p[k]);
    sum.addMultiple(at_p, -static_cast<double>(q[k]));
    x[k] = sum.value() / divisor;
  }
  return {x[0], x[1], x[2]};
}

}  // namespace detail

// The zero of a linear function whose values at p and q, right to a part in 2^29, have different
// signs; `exact(v)` is its value at v as an expansion. Off by less than 2^-23 of its largest
// coordinate.
template <class Exact>
DCM_HD inline Vec3d zeroBetween(const Vec3f& p, const Vec3f& q, double at_p, double at_q,
                                const Exact& exact) {
  constexpr double kMostOffset = 16;  // in largest coordinates of the point
  const bool from_p = fabs(at_p) <= fabs(at_q);
  const Vec3f &base = from_p ? p : q, &other = from_p ? q : p;
  const double share = (from_p ? at_p : at_q) / (from_p ? at_p - at_q : at_q - at_p);
  const Vec3d offset = (toDouble(other) - toDouble(base)) * share;
  const Vec3d point = toDouble(base) + offset;
  if (largestCoordinate(offset) <= kMostOffset * largestCoordinate(point)) return point;
  return detail::exactZeroBetween(p, q, exact(p), exact(q));
}

}  // namespace deformable_contact_monitor
