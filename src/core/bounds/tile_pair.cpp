#include "core/bounds/tile_pair.h"

#include <algorithm>
#include <cmath>

#include "core/cpu/wide_clones.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kTriangles = PosedTile::kTriangles;

// Differences of float32 in double, their squares and sums are right to a few 2^-53.
constexpr double kRounding = 1 - 1e-14;

// The square of the gap of a box with each triangle's box, times kRounding^2 and less.
DCM_WIDE_CLONES void squaredGaps(const float* min, const float* max, const PosedTile& tile,
                                 double* squared) {
  for (std::size_t t = 0; t < kTriangles; ++t) squared[t] = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double lo = min[k], hi = max[k];
    const float *const low = tile.low[k].data(), *const high = tile.high[k].data();
    for (std::size_t t = 0; t < kTriangles; ++t) {
      const double above = low[t] - hi, below = lo - high[t];
      const double gap = most(most(above, below), 0.0);
      squared[t] += gap * gap;
    }
  }
}

// Which of the tile's triangles may be nearer than needed_m to the box; `least_m` is that of the
// others.
std::size_t trianglesNear(const PosedTile& tile, const OrientedBox& box, double needed_m,
                          std::uint8_t* near, double& least_m) {
  double at[3][3 * kTriangles];
  const double size = std::fabs(box.centre.x) + std::fabs(box.centre.y) + std::fabs(box.centre.z) +
                      box.half[0] + box.half[1] + box.half[2];
  const double far =
      most(most(most(-tile.box.min.x, tile.box.max.x), most(-tile.box.min.y, tile.box.max.y)),
           most(-tile.box.min.z, tile.box.max.z));
  const double slack = 1e-12 * (size + 3 * most(far, 0.0));  // as in oriented_box.cpp
  for (std::size_t i = 0; i < tile.vertex_count; ++i) {
    const Vec3d w = toDouble(tile.vertex(i)) - box.centre;
    for (std::size_t k = 0; k < 3; ++k) at[k][i] = dot(box.axis[k], w);
  }
  std::size_t count = 0;
  for (std::size_t t = 0; t < tile.count; ++t) {
    const std::array<std::uint8_t, 3> corner = tile.corners[t];
    double squared = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double p = at[k][corner[0]], q = at[k][corner[1]], r = at[k][corner[2]];
      const double gap = most(least(least(p, q), r), -most(most(p, q), r)) - box.half[k] - slack;
      squared += gap > 0 ? gap * gap : 0;
    }
    const double low_m = squared > 0 ? std::sqrt(squared) * (1 - 1e-12) : 0;
    if (low_m >= needed_m) {
      least_m = least(least_m, low_m);
    } else {
      near[count++] = static_cast<std::uint8_t>(t);
    }
  }
  return count;
}

}  // namespace

double lowerGap(const PosedTile& a, const PosedTile& b) {
  if (a.count == 0 || b.count == 0) return INFINITY;
  return most(std::sqrt(squaredGap(a.box, b.box)) * kRounding, lowerGap(a.oriented, b.oriented));
}

double nearTriangles(const PosedTile& a, const PosedTile& b, double needed_m,
                     std::vector<NearTriangles>& near) {
  near.clear();
  double least_m = INFINITY;
  std::uint8_t of_a[kTriangles], of_b[kTriangles];
  const std::size_t a_count = trianglesNear(a, b.oriented, needed_m, of_a, least_m);
  if (a_count == 0) return least_m;
  const std::size_t b_count = trianglesNear(b, a.oriented, needed_m, of_b, least_m);
  const double needed2 = needed_m * needed_m * (1 + 1e-12);  // so its root is not less
  double left_out2 = INFINITY;
  for (std::size_t i = 0; i < a_count && b_count > 0; ++i) {
    const std::uint8_t s = of_a[i];
    const float min[3] = {a.low[0][s], a.low[1][s], a.low[2][s]};
    const float max[3] = {a.high[0][s], a.high[1][s], a.high[2][s]};
    double squared[kTriangles];
    squaredGaps(min, max, b, squared);
    for (std::size_t j = 0; j < b_count; ++j) {
      const double low2 = squared[of_b[j]] * (kRounding * kRounding);
      if (low2 >= needed2) {
        left_out2 = least(left_out2, low2);
      } else {
        near.push_back({std::sqrt(low2), s, of_b[j]});
      }
    }
  }
  if (needed_m > 1e-44) {
    std::sort(near.begin(), near.end(), [](const NearTriangles& x, const NearTriangles& y) {
      if (x.low_m != y.low_m) return x.low_m < y.low_m;
      return x.a != y.a ? x.a < y.a : x.b < y.b;
    });
  }
  return least(least_m, std::sqrt(left_out2) * kRounding);
}

}  // namespace deformable_contact_monitor
