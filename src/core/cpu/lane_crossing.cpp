#include "core/cpu/lane_crossing.h"

#include <array>
#include <cstddef>

namespace deformable_contact_monitor {
namespace {

// Returns the signs of det[q-p; r-p; s-p].
LaneSigns orientationOf(const LanePoint& p, const LanePoint& q, const LanePoint& r,
                        const LanePoint& s) {
  return LaneProduct(q - p, r - p).signWith(s - p);
}

// The order in which the test takes a triangle's vertices: cyclic from the one that is alone on its
// side of the plane, or reversed from there. The table has both orders for each set of vertices on
// the positive side.
using Order = std::array<std::uint8_t, 3>;
constexpr Order kOrders[8][2] = {
    {{0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}, {0, 2, 1}}, {{1, 2, 0}, {1, 0, 2}}, {{2, 0, 1}, {2, 1, 0}},
    {{2, 0, 1}, {2, 1, 0}}, {{1, 2, 0}, {1, 0, 2}}, {{0, 1, 2}, {0, 2, 1}}, {{0, 0, 0}, {0, 0, 0}}};

// Returns whether two vertices are on the positive side, so that the lone one is on the negative
// side.
bool loneIsNegative(PlaneSides sides) {
  constexpr std::uint8_t kTwo = 1 << 3 | 1 << 5 | 1 << 6;
  return (kTwo >> (sides.plus & 7) & 1) != 0;
}

float coordinate(const FloatLanes& lanes, std::uint8_t i) { return lanes[i]; }

// Gathers the k-th vertex, in its order, of each of four triangles.
LanePoint spread(const LaneTriangle* const (&t)[4], const Order* const (&orders)[4],
                 std::size_t k) {
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

// Does the same as detail::crossingVerdict() (predicates/triangle_intersection.h): each triangle
// begins with the vertex that is alone on its side of the other's plane, and is reversed if the
// other's lone vertex is on the negative side.
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
  const LaneSigns first = orientationOf(a0, spread(a, of_a, 1), b0, spread(b, of_b, 1));
  const LaneSigns second = orientationOf(a0, spread(a, of_a, 2), spread(b, of_b, 2), b0);
  return {first.negative & second.negative, first.positive | second.positive};
}

}  // namespace deformable_contact_monitor
