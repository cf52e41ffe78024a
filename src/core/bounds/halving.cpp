#include "core/bounds/halving.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/predicates/aabb.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kTile = Tiling::kTileTriangles;
constexpr std::size_t kRegion = kTile * Tiling::kRegionTiles;

int longestSide(const PlacedTriangle* first, const PlacedTriangle* last) {
  Aabb box;
  for (const PlacedTriangle* t = first; t != last; ++t) box.include(t->at);
  int longest = 0;
  for (int k = 1; k < 3; ++k) {
    if (box.max[k] - box.min[k] > box.max[longest] - box.min[longest]) longest = k;
  }
  return longest;
}

// Until each stretch of `unit` is together.
void halve(const CycleLimit& limit, PlacedTriangle* first, PlacedTriangle* last, std::size_t unit) {
  const auto count = static_cast<std::size_t>(last - first);
  if (count <= unit || limit.over()) return;
  PlacedTriangle* const middle = first + (count + unit - 1) / unit / 2 * unit;
  const int k = longestSide(first, last);
  const auto less = [k](const PlacedTriangle& a, const PlacedTriangle& b) {
    return a.at[k] != b.at[k] ? a.at[k] < b.at[k] : a.triangle < b.triangle;
  };
  sortWithin(limit, count, less,
             [=](const auto& by) { std::nth_element(first, middle, last, by); });
  halve(limit, first, middle, unit);
  halve(limit, middle, last, unit);
}

}  // namespace

PlacedTriangle placed(const TriangleMesh& mesh, std::uint32_t triangle) {
  const std::uint32_t* corner = &mesh.triangles[3 * std::size_t{triangle}];
  const Vec3f a = mesh.vertex(corner[0]), b = mesh.vertex(corner[1]), c = mesh.vertex(corner[2]);
  const auto mean = [](float x, float y, float z) {
    const float sum = x / 3 + y / 3 + z / 3;
    return std::isfinite(sum) ? sum : 0;
  };
  return {{mean(a.x, b.x, c.x), mean(a.y, b.y, c.y), mean(a.z, b.z, c.z)}, triangle};
}

void appendHalved(const CycleLimit& limit, std::vector<PlacedTriangle>& triangles, Tiling* tiling) {
  PlacedTriangle* const first = triangles.data();
  const std::size_t count = triangles.size();
  halve(limit, first, first + count, kRegion);
  for (std::size_t region = 0; region < count; region += kRegion) {
    const std::size_t end = std::min(count, region + kRegion);
    halve(limit, first + region, first + end, kTile);
    for (std::size_t tile = region; tile < end; tile += kTile) {
      const std::size_t size = std::min(kTile, end - tile);
      for (std::size_t i = tile; i < tile + size; ++i) {
        tiling->triangle.push_back(triangles[i].triangle);
      }
      tiling->tile_begin.push_back(static_cast<std::uint32_t>(tiling->triangle.size()));
    }
    tiling->region_begin.push_back(static_cast<std::uint32_t>(tiling->tileCount()));
  }
}

}  // namespace deformable_contact_monitor
