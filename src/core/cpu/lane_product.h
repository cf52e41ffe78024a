// Determinants of three vectors in float32, four at once, and the signs that are certain.
#pragma once

#include "core/cpu/lane_triangle.h"

namespace deformable_contact_monitor {

struct LanePoint {
  FloatLanes x, y, z;
};

inline LanePoint operator-(const LanePoint& p, const LanePoint& q) {
  return {p.x - q.x, p.y - q.y, p.z - q.z};
}

// A lane is set where that is certain.
struct LaneSigns {
  IntLanes positive, negative;
};

// The cross product of u and w in each lane, and the sizes of its terms: PlaneFilter's and
// EdgeProduct's, in lanes, term by term, and so to the bit.
class LaneProduct {
 public:
  LaneProduct() = default;
  LaneProduct(const LanePoint& u, const LanePoint& w) {
    const FloatLanes m1 = u.y * w.z, m2 = u.z * w.y, m3 = u.z * w.x;
    const FloatLanes m4 = u.x * w.z, m5 = u.x * w.y, m6 = u.y * w.x;
    value_ = {m1 - m2, m3 - m4, m5 - m6};
    // The constant covers products that underflow.
    permanent_ = {sizeOf(m1) + sizeOf(m2) + 1e-37F, sizeOf(m3) + sizeOf(m4) + 1e-37F,
                  sizeOf(m5) + sizeOf(m6) + 1e-37F};
  }

  const LanePoint& value() const { return value_; }

  // The sign of det[u; w; d], where u, w and d are differences of points, rounded, or vectors that
  // are exact. With e = 2^-24 a difference is off by e of itself, a product m of two by 3 e, m - m'
  // by 4 e of |m| + |m'|, its product with d by 6 e, and two more sums add 2 e: less than
  // (7 + 56 e) e of the permanent as rounded (Shewchuk's bound for orient3d). Products that
  // underflow are off by at most 2^-150 each; the constants cover that. Each partial sum of the
  // permanent is at least the value's in size: so what overflows makes the error infinite or NaN,
  // and nothing is certain.
  LaneSigns signWith(const LanePoint& d) const {
    constexpr float kBound = 4.3e-7F;
    const FloatLanes det = value_.x * d.x + value_.y * d.y + value_.z * d.z;
    const FloatLanes error = kBound * (permanent_.x * sizeOf(d.x) + permanent_.y * sizeOf(d.y) +
                                       permanent_.z * sizeOf(d.z)) +
                             1e-36F;
    return {det > error, det < -error};
  }

  static FloatLanes sizeOf(const FloatLanes& x) { return most(x, -x); }

 private:
  LanePoint value_, permanent_;
};

}  // namespace deformable_contact_monitor
