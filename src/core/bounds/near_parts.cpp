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

// Computes the square of the gap between the box of a triangle of `a` and the box of each triangle
// of `b` [m^2]. Entries beyond the tile's count are computed too: loops of a fixed length become
// vector instructions.
DCM_WIDE_CLONES void squaredGaps(const PosedTile& a, std::size_t s, const PosedTile& b,
                                 double* squared) {
  for (std::size_t t = 0; t < kTriangles; ++t) squared[t] = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double lo = a.low[k][s], hi = a.high[k][s];
    const float *const low = b.low[k].data(), *const high = b.high[k].data();
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

// Returns a number that is at least the distance of each of a tile's vertices from the origin, in
// the sum of coordinates.
double sizeOf(const PosedTile& tile) {
  double size = 0;
  for (int k = 0; k < 3; ++k) size += most(std::fabs(tile.box.min[k]), std::fabs(tile.box.max[k]));
  return size;
}

// Writes the places of a tile's vertices along a direction, relative to a point [m times the
// direction's length].
DCM_WIDE_CLONES void placesAlong(const Vec3d& direction, const Vec3d& from, const PosedTile& tile,
                                 double* at) {
  const double x = direction.x, y = direction.y, z = direction.z;
  const double from_x = from.x, from_y = from.y, from_z = from.z;
  for (std::size_t i = 0; i < tile.vertex_count; ++i) {
    at[i] = x * (tile.x[i] - from_x) + y * (tile.y[i] - from_y) + z * (tile.z[i] - from_z);
  }
}

// Bounds distances by the places of two tiles' vertices along a direction from a to b.
class GapAlong {
 public:
  GapAlong(const Vec3d& direction, const PosedTile& a, const PosedTile& b)
      : scale_((1 - 1e-12) / std::sqrt(dot(direction, direction))),
        slack_m_(1e-14 * (sizeOf(a) + sizeOf(b))) {
    const Vec3d from = toDouble(a.vertex(0));
    placesAlong(direction, from, a, of_a_);
    placesAlong(direction, from, b, of_b_);
    // NOLINTBEGIN(clang-analyzer-core.uninitialized.Assign): a tile has vertices.
    high_a_ = *std::max_element(of_a_, of_a_ + a.vertex_count);
    low_b_ = *std::min_element(of_b_, of_b_ + b.vertex_count);
    // NOLINTEND(clang-analyzer-core.uninitialized.Assign)
  }

  // Return lower bounds of the distances between the tiles, between a triangle and the other tile,
  // and between two triangles [m]; they may be negative. `s` and `t` are triangles of a and of b.
  double ofTiles() const { return gap(high_a_, low_b_); }
  double ofA(const PosedTile& a, std::size_t s) const { return gap(highest(a, s), low_b_); }
  double ofB(const PosedTile& b, std::size_t t) const { return gap(high_a_, lowest(b, t)); }
  double gap(double high_a, double low_b) const { return (low_b - high_a) * scale_ - slack_m_; }

  double highest(const PosedTile& a, std::size_t s) const {
    const std::array<std::uint8_t, 3>& corner = a.corners[s];
    return most(most(of_a_[corner[0]], of_a_[corner[1]]), of_a_[corner[2]]);
  }
  double lowest(const PosedTile& b, std::size_t t) const {
    const std::array<std::uint8_t, 3>& corner = b.corners[t];
    return least(least(of_b_[corner[0]], of_b_[corner[1]]), of_b_[corner[2]]);
  }

 private:
  double scale_, slack_m_;
  double of_a_[3 * kTriangles], of_b_[3 * kTriangles];
  double high_a_, low_b_;
};

// The triangles of two tiles that may be near the other tile, with the ends of each one towards the
// other tile along a direction.
struct NearEnds {
  std::size_t a_count = 0, b_count = 0;
  std::uint8_t a[kTriangles], b[kTriangles];
  double end_a[kTriangles], end_b[kTriangles];

  // Lowers least_m to the least distance of the other triangles.
  NearEnds(const GapAlong& along, const PosedTile& tile_a, const PosedTile& tile_b, double needed_m,
           double& least_m) {
    const auto keepNear = [&](double low_m, std::size_t t, double end, std::uint8_t* near,
                              double* ends, std::size_t* count) {
      if (low_m >= needed_m) {
        least_m = least(least_m, low_m);
        return;
      }
      ends[*count] = end;
      near[(*count)++] = static_cast<std::uint8_t>(t);
    };
    for (std::size_t s = 0; s < tile_a.count; ++s) {
      keepNear(along.ofA(tile_a, s), s, along.highest(tile_a, s), a, end_a, &a_count);
    }
    for (std::size_t t = 0; t < tile_b.count; ++t) {
      keepNear(along.ofB(tile_b, t), t, along.lowest(tile_b, t), b, end_b, &b_count);
    }
  }
};

// Orders pairs of triangles, the nearest first.
void sortByBound(std::vector<NearTriangles>& near) {
  std::sort(near.begin(), near.end(), [](const NearTriangles& x, const NearTriangles& y) {
    if (x.low_m != y.low_m) return x.low_m < y.low_m;
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
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

double lowerGapAlong(const Vec3d& direction, const PosedTile& a, const PosedTile& b) {
  return GapAlong(direction, a, b).ofTiles();
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
    double squared[kTriangles];
    squaredGaps(a, s, b, squared);
    for (std::size_t j = 0; j < b_count; ++j) {
      const double low2 = squared[of_b[j]] * (kRounding * kRounding);
      if (low2 >= needed2) {
        left_out2 = least(left_out2, low2);
      } else {
        near.push_back({std::sqrt(low2), s, of_b[j], low2 == 0});
      }
    }
  }
  // Without a margin and a tolerance usually only overlapping boxes are left, and there is no order
  // among them.
  const bool have_order = std::any_of(near.begin(), near.end(),
                                      [](const NearTriangles& pair) { return pair.low_m > 0; });
  if (have_order) sortByBound(near);
  return least(least_m, std::sqrt(left_out2) * kRounding);
}

double nearTrianglesAlong(const Vec3d& direction, const PosedTile& a, const PosedTile& b,
                          double needed_m, std::vector<NearTriangles>& near) {
  near.clear();
  double least_m = INFINITY;
  const GapAlong along(direction, a, b);
  const NearEnds ends(along, a, b, needed_m, least_m);
  const double needed2 = needed_m * needed_m * (1 + 1e-12);  // so its root is not less
  double left_out2 = INFINITY;
  for (std::size_t i = 0; i < ends.a_count && ends.b_count > 0; ++i) {
    const std::uint8_t s = ends.a[i];
    double squared[kTriangles];
    squaredGaps(a, s, b, squared);
    for (std::size_t j = 0; j < ends.b_count; ++j) {
      const double low2 = squared[ends.b[j]] * (kRounding * kRounding);
      const double along_m = along.gap(ends.end_a[i], ends.end_b[j]);
      if (along_m >= needed_m) {
        least_m = least(least_m, along_m);
      } else if (low2 >= needed2) {
        left_out2 = least(left_out2, low2);
      } else {
        near.push_back({most(std::sqrt(low2), along_m), s, ends.b[j], low2 == 0});
      }
    }
  }
  sortByBound(near);
  return least(least_m, std::sqrt(left_out2) * kRounding);
}

}  // namespace deformable_contact_monitor
