#include "core/bounds/region_pair.h"

#include <cmath>

#include "core/bounds/tile_pair.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kRounding = 1 - 1e-14;  // of squaredGap() and its root

// +inf where one is empty.
double lowerGap(const Aabb& a, const Aabb& b) {
  if (a.empty() || b.empty()) return INFINITY;
  const double squared = squaredGap(a, b);
  return squared > 0 ? std::sqrt(squared) * kRounding : 0;
}

struct TileBox {
  Aabb box;
  std::uint32_t tile;
};

// The tiles of a region that may be nearer than needed_m to a box; `least_m` is that of the others.
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

}  // namespace

double nearRegions(const BodyTiles& a, std::size_t region_a, const BodyTiles& b, double needed_m,
                   std::vector<NearParts>& near) {
  double least_m = INFINITY;
  const Aabb& box = a.regions()[region_a];
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
      double low_m = lowerGap(of_a[i].box, of_b[j].box);
      if (low_m < needed_m)
        low_m = most(low_m, lowerGap(a.tile(of_a[i].tile), b.tile(of_b[j].tile)));
      if (low_m >= needed_m) {
        least_m = least(least_m, low_m);
      } else {
        near.push_back({low_m, of_a[i].tile, of_b[j].tile});
      }
    }
  }
  return least_m;
}

}  // namespace deformable_contact_monitor
