// Intervals of triangles along the four diagonals of space. Two triangles whose boxes meet are
// often apart along a diagonal, and this test is cheaper than one with the triangles' planes. Such
// directions bound a k-DOP (J. T. Klosowski et al., Efficient Collision Detection Using Bounding
// Volume Hierarchies of k-DOPs, 1998).
#pragma once

#include <cmath>
#include <cstdint>

#include "core/rules/intervals.h"
#include "core/rules/scene_scale.h"

namespace deformable_contact_monitor {

// Positions along the diagonals (1, 1, 1), (1, 1, -1), (1, -1, 1) and (1, -1, -1) [m], as integers.
// Any frame gives correct results; a good one covers the scene.
struct DiagonalFrame {
  Quantiser along[4];

  DiagonalFrame() = default;
  explicit DiagonalFrame(const SceneScale& scale) {
    const Vec3d o = scale.origin;
    const double reach = 3 / scale.scale;  // of a point in the scene, along a diagonal
    const double middle[4] = {o.x + o.y + o.z, o.x + o.y - o.z, o.x - o.y + o.z, o.x - o.y - o.z};
    for (int k = 0; k < 4; ++k) along[k] = Quantiser::around(middle[k], reach);
  }
};

// The intervals along the four diagonals, two in each part.
struct alignas(16) DiagonalBox {
  PackedBox parts[2];

  // Returns what no points have: the least ends are above the greatest ones.
  DCM_HD static DiagonalBox none() {
    return {{{~kPackedGuard, kPackedGuard}, {~kPackedGuard, kPackedGuard}}};
  }
};

// Returns false only if the triangles are apart.
DCM_HD inline bool intersects(const DiagonalBox& a, const DiagonalBox& b) {
  return intersects(a.parts[0], b.parts[0]) & intersects(a.parts[1], b.parts[1]);
}

// Returns the intervals of all that lies within `grown_m` of the convex hull of the points [m],
// which may have been rounded once.
template <int kPoints>
DCM_HD inline DiagonalBox diagonalBox(const Vec3f v[kPoints], float grown_m,
                                      const DiagonalFrame& frame) {
  Interval i[4];
  float reach = 0;
  for (int k = 0; k < kPoints; ++k) {
    const float sum = v[k].x + v[k].y, difference = v[k].x - v[k].y;
    const float p[4] = {sum + v[k].z, sum - v[k].z, difference + v[k].z, difference - v[k].z};
    for (int d = 0; d < 4; ++d) {
      i[d] = k == 0 ? Interval{p[d], p[d]} : Interval{least(i[d].lo, p[d]), most(i[d].hi, p[d])};
    }
    reach = most(reach, fabsf(v[k].x) + fabsf(v[k].y) + fabsf(v[k].z));
  }
  // u = 2^-24: 1 for each coordinate, 2 for the sums, 1 for the sum below, and slack. A diagonal's
  // vector has the length sqrt(3).
  constexpr float kError = 6 * kScaledError, kLength = 1.7321F;
  const float pad = reach * kError + grown_m * kLength + 1e-44F;
  if (!(reach + pad < 1e37F)) return {{{0, ~std::uint32_t{0}}, {0, ~std::uint32_t{0}}}};
  for (Interval& each : i) each = {each.lo - pad, each.hi + pad};
  return {{pack(frame.along, i), pack(frame.along + 2, i + 2)}};
}

}  // namespace deformable_contact_monitor
