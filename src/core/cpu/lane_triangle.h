// A triangle spread over vector lanes: the CPU's form for the filters that most pairs end in.
#pragma once

#include <array>
#include <cstdint>

#include "core/predicates/plane_filter.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

using FloatLanes = float __attribute__((vector_size(16)));
using IntLanes = int __attribute__((vector_size(16)));

// One bit per lane, its sign: of a mask, whether it is set.
inline int laneBits(const IntLanes& lanes) {
#ifdef __SSE__
  return __builtin_ia32_movmskps(reinterpret_cast<const FloatLanes&>(lanes));
#else
  const IntLanes bits = (lanes < 0) & IntLanes{1, 2, 4, 8};
  return bits[0] | bits[1] | bits[2] | bits[3];
#endif
}

// The fourth lane repeats the third vertex.
struct LaneTriangle {
  FloatLanes x, y, z;

  LaneTriangle() = default;
  explicit LaneTriangle(const Triangle& t)
      : x{t.v[0].x, t.v[1].x, t.v[2].x, t.v[2].x},
        y{t.v[0].y, t.v[1].y, t.v[2].y, t.v[2].y},
        z{t.v[0].z, t.v[1].z, t.v[2].z, t.v[2].z} {}
};

// Which of a triangle's vertices are certainly strictly on the one side of a plane, and which on
// the other, as bits; the fourth bit is the third vertex's.
struct PlaneSides {
  std::uint8_t plus, minus;

  bool allOnOne() const { return (plus == 15) | (minus == 15); }
  // All but those that these bits tell, of lanes; true also if there are no others.
  bool othersOnOne(int bits) const { return ((plus | bits) == 15) | ((minus | bits) == 15); }
  bool allStrict() const { return (plus | minus) == 15; }
  // As PlaneFilter::side.
  int of(int vertex) const { return (plus >> vertex & 1) - (minus >> vertex & 1); }
};

inline PlaneSides sidesOf(const PlaneFilter& plane, const LaneTriangle& t) {
  FloatLanes value, error;
  plane.distance(t.x, t.y, t.z, value, error);
  return {static_cast<std::uint8_t>(laneBits(value > error)),
          static_cast<std::uint8_t>(laneBits(value < -error))};
}

// Identities of three vertices; the fourth lane repeats the third.
inline IntLanes identityLanes(const std::array<std::uint32_t, 3>& id) {
  return IntLanes{static_cast<int>(id[0]), static_cast<int>(id[1]), static_cast<int>(id[2]),
                  static_cast<int>(id[2])};
}

// Which of a's vertices, as bits, are also b's. By value, and so in registers: compilers then make
// one shuffle of each braced list.
inline int sharedBits(IntLanes a, IntLanes b) {
  return laneBits((a == b) | (a == IntLanes{b[1], b[2], b[0], b[0]}) |
                  (a == IntLanes{b[2], b[0], b[1], b[1]}));
}

}  // namespace deformable_contact_monitor
