#include "core/cpu/lane_crossing.h"

#include <array>

namespace deformable_contact_monitor {
namespace {

struct LanePoint {
  FloatLanes x, y, z;
};

LanePoint operator-(const LanePoint& p, const LanePoint& q) {
  return {p.x - q.x, p.y - q.y, p.z - q.z};
}

FloatLanes sizeOf(const FloatLanes& x) { return most(x, -x); }

// The sign of det[q-p; r-p; s-p] in each lane. This is PlaneFilter of (p, q, r), asked about s, term
// by term, and so is its error: with u = 2^-24 each difference is off by u of itself, each product
// of two by 3 u, their difference m by 4 u of the sum of their sizes, its product with the third
// difference by 6 u, and sums of three add 2 u: less than (7 + 56 u) u of the permanent, as rounded.
// Products that underflow are off by at most 2^-150 each; the constants cover that. What overflows
// makes the error infinite or NaN first, for each of its terms is at least the value's in size: then
// nothing is certain.
struct LaneOrientation {
  FloatLanes value, error;

  LaneOrientation(const LanePoint& p, const LanePoint& q, const LanePoint& r, const LanePoint& s) {
    const LanePoint u = q - p, w = r - p, d = s - p;
    const FloatLanes m1 = u.y * w.z, m2 = u.z * w.y, m3 = u.z * w.x;
    const FloatLanes m4 = u.x * w.z, m5 = u.x * w.y, m6 = u.y * w.x;
    value = (m1 - m2) * d.x + (m3 - m4) * d.y + (m5 - m6) * d.z;
    constexpr float kUnderflow = 1e-37F, kBound = 4.3e-7F;
    error = kBound * ((sizeOf(m1) + sizeOf(m2) + kUnderflow) * sizeOf(d.x) +
                      (sizeOf(m3) + sizeOf(m4) + kUnderflow) * sizeOf(d.y) +
                      (sizeOf(m5) + sizeOf(m6) + kUnderflow) * sizeOf(d.z)) +
            1e-36F;
  }

  IntLanes positive() const { return value > error; }
  IntLanes negative() const { return value < -error; }
};

// The vertices of a triangle in their order, from the one that is alone on its side, or the other
// way round from there; by which of them are on the positive side.
using Order = std::array<std::uint8_t, 3>;
constexpr Order kOrders[8][2] = {{{0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}, {0, 2, 1}},
                                 {{1, 2, 0}, {1, 0, 2}}, {{2, 0, 1}, {2, 1, 0}},
                                 {{2, 0, 1}, {2, 1, 0}}, {{1, 2, 0}, {1, 0, 2}},
                                 {{0, 1, 2}, {0, 2, 1}}, {{0, 0, 0}, {0, 0, 0}}};

// Whether two vertices are on the positive side, and so the lone one on the negative.
bool loneIsNegative(PlaneSides sides) {
  constexpr std::uint8_t kTwo = 1 << 3 | 1 << 5 | 1 << 6;
  return (kTwo >> (sides.plus & 7) & 1) != 0;
}

float coordinate(const FloatLanes& lanes, std::uint8_t i) { return lanes[i]; }

// In each lane a vertex of one of four triangles.
LanePoint spread(const LaneTriangle* const (&t)[4], const Order* const (&orders)[4], std::size_t k) {
  const std::uint8_t i = (*orders[0])[k], j = (*orders[1])[k], l = (*orders[2])[k],
                     m = (*orders[3])[k];
  return {FloatLanes{coordinate(t[0]->x, i), coordinate(t[1]->x, j), coordinate(t[2]->x, l),
                     coordinate(t[3]->x, m)},
          FloatLanes{coordinate(t[0]->y, i), coordinate(t[1]->y, j), coordinate(t[2]->y, l),
                     coordinate(t[3]->y, m)},
          FloatLanes{coordinate(t[0]->z, i), coordinate(t[1]->z, j), coordinate(t[2]->z, l),
                     coordinate(t[3]->z, m)}};
}

}  // namespace

// As detail::crossingVerdict: each begins with the vertex that is alone on its side of the other's
// plane, and is turned round where the other's is on the negative side.
LaneCrossings crossingsOf(const CrossingPair (&pairs)[4]) {
  const LaneTriangle *a[4], *b[4];
  const Order *of_a[4], *of_b[4];
  for (int i = 0; i < 4; ++i) {
    const CrossingPair& pair = pairs[i];
    a[i] = pair.a;
    b[i] = pair.b;
    of_a[i] = &kOrders[pair.sides_a.plus & 7][loneIsNegative(pair.sides_b) ? 1 : 0];
    of_b[i] = &kOrders[pair.sides_b.plus & 7][loneIsNegative(pair.sides_a) ? 1 : 0];
  }
  const LanePoint a0 = spread(a, of_a, 0), b0 = spread(b, of_b, 0);
  const LaneOrientation first(a0, spread(a, of_a, 1), b0, spread(b, of_b, 1));
  const LaneOrientation second(a0, spread(a, of_a, 2), spread(b, of_b, 2), b0);
  return {first.negative() & second.negative(), first.positive() | second.positive()};
}

}  // namespace deformable_contact_monitor
