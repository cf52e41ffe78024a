// Makes a tile of a body in the scene frame. In most tiles all vertices are finite, and the lists
// of the tiling are copied as they are. Otherwise the triangles with other vertices are left out.
#include "core/bounds/posed_tile.h"

#include <algorithm>

namespace deformable_contact_monitor {

void PosedTile::make(const Tiling& tiling, std::size_t tile, const PosedBody& body) {
  const std::uint32_t first = tiling.vertex_begin[tile];
  vertex_count = tiling.vertex_begin[tile + 1] - first;
  float check = 0;  // becomes NaN with the first coordinate that is not finite
  for (std::size_t i = 0; i < vertex_count; ++i) {
    const Vec3f v = body.vertex(tiling.vertex[first + i]);
    x[i] = v.x;
    y[i] = v.y;
    z[i] = v.z;
    check += (v.x - v.x) + (v.y - v.y) + (v.z - v.z);
  }
  if (check == 0) {
    takeAll(tiling, tile);
  } else {
    takeFinite(tiling, tile);
  }
  if (count > 0) findBoxes();
}

void PosedTile::takeAll(const Tiling& tiling, std::size_t tile) {
  const std::uint32_t first = tiling.tile_begin[tile];
  count = tiling.tile_begin[tile + 1] - first;
  for (std::size_t t = 0; t < count; ++t) {
    triangle[t] = tiling.triangle[first + t];
    corners[t] = tiling.corners[first + t];
  }
}

// Takes the triangles whose vertices are finite, and renumbers the vertices that these still use.
void PosedTile::takeFinite(const Tiling& tiling, std::size_t tile) {
  constexpr std::uint8_t kUnused = 255;
  std::array<std::uint8_t, 3 * kTriangles> place;
  place.fill(kUnused);
  const std::array<float, 3 *kTriangles> all_x = x, all_y = y, all_z = z;
  count = vertex_count = 0;
  for (std::uint32_t slot = tiling.tile_begin[tile]; slot < tiling.tile_begin[tile + 1]; ++slot) {
    const std::array<std::uint8_t, 3> corner = tiling.corners[slot];
    const bool finite = std::all_of(corner.begin(), corner.end(), [&](std::uint8_t i) {
      return isFinite(Vec3f{all_x[i], all_y[i], all_z[i]});
    });
    if (!finite) continue;
    triangle[count] = tiling.triangle[slot];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint8_t i = corner[k];
      if (place[i] == kUnused) {
        x[vertex_count] = all_x[i];
        y[vertex_count] = all_y[i];
        z[vertex_count] = all_z[i];
        place[i] = static_cast<std::uint8_t>(vertex_count++);
      }
      corners[count][k] = place[i];
    }
    ++count;
  }
}

// The mean normal of the triangles is the direction in which the oriented box is thin.
void PosedTile::findBoxes() {
  box = Aabb();
  Vec3d normal;  // the sum of the triangles' normals, weighted by area
  for (std::size_t t = 0; t < count; ++t) {
    const Triangle hull = posed(t);
    const Aabb own = boxOf(hull);
    box.include(own);
    for (std::size_t k = 0; k < 3; ++k) {
      low[k][t] = own.min[static_cast<int>(k)];
      high[k][t] = own.max[static_cast<int>(k)];
    }
    const Vec3d o = toDouble(hull.v[0]);
    normal = normal + cross(toDouble(hull.v[1]) - o, toDouble(hull.v[2]) - o);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    std::fill(low[k].begin() + static_cast<std::ptrdiff_t>(count), low[k].end(), low[k][count - 1]);
    std::fill(high[k].begin() + static_cast<std::ptrdiff_t>(count), high[k].end(),
              high[k][count - 1]);
  }
  oriented = orientedBoxOf(x.data(), y.data(), z.data(), vertex_count, normal);
}

}  // namespace deformable_contact_monitor
