// Triangles, points and determinants in vector lanes: what the CPU's float32 filters compute with.
//
// Vectors are the compiler's own (GCC's and Clang's vector extension), four floats wide, so that
// the same code runs on x86-64 and AArch64. A mask has all bits of a lane set where a comparison
// holds.
#pragma once

#include <array>
#include <cstdint>

#include "core/common/lanes.h"
#include "core/predicates/float32_filters.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// A triangle with one vertex in each lane. The fourth lane repeats the third vertex.
struct LaneTriangle {
  FloatLanes x, y, z;

  LaneTriangle() = default;
  explicit LaneTriangle(const Triangle& t)
      : x{t.v[0].x, t.v[1].x, t.v[2].x, t.v[2].x},
        y{t.v[0].y, t.v[1].y, t.v[2].y, t.v[2].y},
        z{t.v[0].z, t.v[1].z, t.v[2].z, t.v[2].z} {}
};

// Tells which of a triangle's vertices certainly lie strictly on the positive side of a plane
// (`plus`), and which on the negative side (`minus`), one bit each. The fourth bit repeats the
// third.
struct PlaneSides {
  std::uint8_t plus, minus;

  bool allOnOne() const { return (plus == 15) | (minus == 15); }
  // Returns whether all vertices except those in `bits` lie on one side; true too if there are no
  // others.
  bool othersOnOne(int bits) const { return ((plus | bits) == 15) | ((minus | bits) == 15); }
  bool allStrict() const { return (plus | minus) == 15; }
  // Returns 1, -1 or 0, as PlaneFilter::side() does for that vertex.
  int of(int vertex) const { return (plus >> vertex & 1) - (minus >> vertex & 1); }
};

// Returns on which sides of the plane the vertices of `t` certainly lie.
inline PlaneSides sidesOf(const PlaneFilter& plane, const LaneTriangle& t) {
  FloatLanes value, error;
  plane.distance(t.x, t.y, t.z, value, error);
  return {static_cast<std::uint8_t>(laneBits(value > error)),
          static_cast<std::uint8_t>(laneBits(value < -error))};
}

// Returns the ids of three vertices in lanes. The fourth lane repeats the third.
inline IntLanes identityLanes(const std::array<std::uint32_t, 3>& id) {
  return IntLanes{static_cast<int>(id[0]), static_cast<int>(id[1]), static_cast<int>(id[2]),
                  static_cast<int>(id[2])};
}

// Returns as bits which of a's vertices are also b's. The arguments are passed by value, in
// registers: compilers then make one shuffle of each braced list.
inline int sharedBits(IntLanes a, IntLanes b) {
  return laneBits((a == b) | (a == IntLanes{b[1], b[2], b[0], b[0]}) |
                  (a == IntLanes{b[2], b[0], b[1], b[1]}));
}

// A point or vector in each lane.
struct LanePoint {
  FloatLanes x, y, z;
};

inline LanePoint operator-(const LanePoint& p, const LanePoint& q) {
  return {p.x - q.x, p.y - q.y, p.z - q.z};
}

// A lane is set where the sign is certain.
struct LaneSigns {
  IntLanes positive, negative;
};

// The cross product of u and w in each lane, and the sizes of its terms. Each operation is that of
// PlaneFilter and EdgeProduct, in the same order, so that results are equal bit for bit.
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

  // Returns the sign of det[u; w; d] where it is certain. u, w and d are rounded differences of
  // points, or exact vectors.
  //
  // Error bound, with e = 2^-24: a difference has a relative error of e, a product m of two
  // differences 3 e. m - m' has an error of 4 e times |m| + |m'|, its product with d of 6 e, and
  // two more sums add 2 e. So the total is less than (7 + 56 e) e times the permanent as rounded,
  // which is Shewchuk's bound for orient3d ("Adaptive Precision Floating-Point Arithmetic", 1997).
  // A product that underflows is off by at most 2^-150; the constants cover that. Each partial sum
  // of the permanent is at least as large as that of the value, so that an overflow makes the error
  // infinite or NaN, and no sign is certain.
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
