// Compares boxes to find the parts of two bodies that may be near each other. Axis-aligned boxes
// come first. The oriented boxes of tiles are thinner, but need posed vertices, so a search
// compares them only where the others are near. All gaps are rounded down: no part is left out by
// mistake.
#include "core/bounds/near_parts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/common/lanes.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kTriangles = PosedTile::kTriangles;

// Differences of float32 numbers in double, their squares and sums have a relative error of a few
// 2^-53. Bounds are multiplied by this, so that rounding never makes them too large.
constexpr double kRounding = 1 - 1e-14;

// Returns a lower bound of the distance between the points of two boxes [m]; +inf if one is empty.
double lowerGap(const Aabb& a, const Aabb& b) {
  if (a.empty() || b.empty()) return INFINITY;
  const double squared = squaredGap(a, b);
  return squared > 0 ? std::sqrt(squared) * kRounding : 0;
}

// Keeps the box of a tile, so that it is not made again for each tile of the other region.
struct TileBox {
  Aabb box;
  std::uint32_t tile;
};

// Finds the tiles of a region that may be nearer than needed_m to a box. Lowers least_m to the
// least distance of the others. Returns how many it found.
std::size_t tilesNear(const BodyTiles& body, std::size_t region, const Aabb& other, double needed_m,
                      TileBox* near, double& least_m) {
  std::size_t count = 0;
  for (std::size_t tile = body.tileBegin(region); tile < body.tileEnd(region); ++tile) {
    const Aabb box = body.tileBox(tile);
    const double low_m = lowerGap(box, other);
    if (low_m >= needed_m) {
      least_m = least(least_m, low_m);
    } else {
      near[count++] = {box, static_cast<std::uint32_t>(tile)};
    }
  }
  return count;
}

// Computes the square of the gap between a box and the box of each of a tile's triangles [m^2].
// Entries beyond the tile's count are computed too: loops of a fixed length become vector
// instructions.
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

// Finds the triangles of a tile that may be nearer than needed_m to an oriented box, by the gaps
// along the box's axes. Lowers least_m to the least distance of the others. Returns how many it
// found.
std::size_t trianglesNear(const PosedTile& tile, const OrientedBox& box, double needed_m,
                          std::uint8_t* near, double& least_m) {
  double at[3][3 * kTriangles];
  const double size = std::fabs(box.centre.x) + std::fabs(box.centre.y) + std::fabs(box.centre.z) +
                      box.half[0] + box.half[1] + box.half[2];
  const double far =
      most(most(most(-tile.box.min.x, tile.box.max.x), most(-tile.box.min.y, tile.box.max.y)),
           most(-tile.box.min.z, tile.box.max.z));
  const double slack = 1e-12 * (size + 3 * most(far, 0.0));  // as in posed_tile.cpp
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

double nearRegions(const BodyTiles& a, std::size_t region_a, const BodyTiles& b, double needed_m,
                   std::vector<NearParts>& near) {
  double least_m = INFINITY;
  const Aabb& box = a.regions()[region_a];
  // One test against all of b is enough for most regions of bodies that are far apart.
  const double of_all_m = lowerGap(box, b.box());
  if (of_all_m >= needed_m) return of_all_m;
  for (std::size_t r = 0; r < b.regions().size(); ++r) {
    const double low_m = lowerGap(box, b.regions()[r]);
    if (low_m >= needed_m) {
      least_m = least(least_m, low_m);
    } else {
      near.push_back({low_m, static_cast<std::uint32_t>(region_a), static_cast<std::uint32_t>(r)});
    }
  }
  return least_m;
}

double nearTiles(const BodyTiles& a, std::size_t region_a, const BodyTiles& b, std::size_t region_b,
                 double needed_m, std::vector<NearParts>& near) {
  near.clear();
  double least_m = INFINITY;
  TileBox of_a[Tiling::kRegionTiles], of_b[Tiling::kRegionTiles];
  const std::size_t a_count =
      tilesNear(a, region_a, b.regions()[region_b], needed_m, of_a, least_m);
  if (a_count == 0) return least_m;
  const std::size_t b_count =
      tilesNear(b, region_b, a.regions()[region_a], needed_m, of_b, least_m);
  for (std::size_t i = 0; i < a_count; ++i) {
    for (std::size_t j = 0; j < b_count; ++j) {
      const double low_m = lowerGap(of_a[i].box, of_b[j].box);
      if (low_m >= needed_m) {
        least_m = least(least_m, low_m);
      } else {
        near.push_back({low_m, of_a[i].tile, of_b[j].tile});
      }
    }
  }
  return least_m;
}

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
  // Without a margin and a tolerance only overlapping boxes are left, so there is no order among
  // them.
  if (needed_m > 1e-44) {
    std::sort(near.begin(), near.end(), [](const NearTriangles& x, const NearTriangles& y) {
      if (x.low_m != y.low_m) return x.low_m < y.low_m;
      return x.a != y.a ? x.a < y.a : x.b < y.b;
    });
  }
  return least(least_m, std::sqrt(left_out2) * kRounding);
}

}  // namespace deformable_contact_monitor
