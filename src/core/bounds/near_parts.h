// Finds the parts of two bodies that may be near each other: pairs of regions, of tiles in two
// regions, and of triangles in two tiles. The functions near...() leave out only pairs that are
// certainly at least `needed_m` > 0 apart [m]. They return a lower bound of the distance of all
// pairs that they left out [m], or +inf if they left out none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/bounds/body_tiles.h"
#include "core/bounds/posed_tile.h"

namespace deformable_contact_monitor {

// A pair of parts: a region or tile of the first body and one of the second.
struct NearParts {
  double low_m;  // they are certainly no nearer than this [m]
  std::uint32_t a, b;
};

// A pair of triangles, given by their places in their tiles.
struct NearTriangles {
  double low_m;  // they are certainly no nearer than this [m]
  std::uint8_t a, b;
  bool boxes_meet;  // otherwise they do not intersect
};

// Adds to `near` the pairs of region `region_a` of a with regions of b, in the order of b's.
double nearRegions(const BodyTiles& a, std::size_t region_a, const BodyTiles& b, double needed_m,
                   std::vector<NearParts>& near);

// Fills `near` with the pairs of tiles of two regions, in their order. It compares the boxes along
// the axes alone, so no vertex is posed.
double nearTiles(const BodyTiles& a, std::size_t region_a, const BodyTiles& b, std::size_t region_b,
                 double needed_m, std::vector<NearParts>& near);

// Fills `near` with the pairs of triangles of two tiles, the nearest first.
double nearTriangles(const PosedTile& a, const PosedTile& b, double needed_m,
                     std::vector<NearTriangles>& near);

// Does the same with bounds along a direction from a to b, of any length but zero. If the nearest
// points of the tiles lie in about this direction, fewer pairs are left, and it is faster.
double nearTrianglesAlong(const Vec3d& direction, const PosedTile& a, const PosedTile& b,
                          double needed_m, std::vector<NearTriangles>& near);

// Returns a lower bound of the distance between the triangles of two tiles [m]; +inf if one tile
// has no triangle.
double lowerGap(const PosedTile& a, const PosedTile& b);

// Returns another one, from the vertices of two tiles that have triangles, along a direction from a
// to b of any length but zero. It may be negative.
double lowerGapAlong(const Vec3d& direction, const PosedTile& a, const PosedTile& b);

}  // namespace deformable_contact_monitor
