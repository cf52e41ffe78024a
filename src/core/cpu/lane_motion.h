// Pairs of moving triangles spread over vector lanes.
#pragma once

#include <cstddef>

#include "core/cpu/lane_triangle.h"
#include "core/predicates/swept_polynomials.h"
#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

constexpr std::size_t kLanes = sizeof(FloatLanes) / sizeof(float);

template <>
struct Rounding<FloatLanes> : Rounding<float> {};

using LaneVector = Vector<FloatLanes>;

// A pair of triangles in each lane, at both ends of the step.
struct LanePairs {
  struct State {
    LaneVector a[3], b[3];
  } from, to;

  LanePairs(const MovingTriangle* const (&a)[kLanes], const MovingTriangle* const (&b)[kLanes]) {
    for (int i = 0; i < 3; ++i) {
      from.a[i] = spread([&a, i](int lane) -> const Vec3f& { return a[lane]->from.v[i]; });
      from.b[i] = spread([&b, i](int lane) -> const Vec3f& { return b[lane]->from.v[i]; });
      to.a[i] = spread([&a, i](int lane) -> const Vec3f& { return a[lane]->to.v[i]; });
      to.b[i] = spread([&b, i](int lane) -> const Vec3f& { return b[lane]->to.v[i]; });
    }
  }

 private:
  template <class Points>
  static LaneVector spread(const Points& at) {
    const Vec3f &p = at(0), &q = at(1), &r = at(2), &s = at(3);
    return {{FloatLanes{p.x, q.x, r.x, s.x}, FloatLanes{p.y, q.y, r.y, s.y},
             FloatLanes{p.z, q.z, r.z, s.z}}};
  }
};

inline LaneVector minus(const LaneVector& p, const LaneVector& q) {
  return {{p.x[0] - q.x[0], p.x[1] - q.x[1], p.x[2] - q.x[2]}};
}

}  // namespace deformable_contact_monitor
