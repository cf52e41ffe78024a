// Pairs of triangles of two tiles that may be near each other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/bounds/posed_tile.h"

namespace deformable_contact_monitor {

// Triangles by their places in their tiles; certainly no nearer than low_m [m].
struct NearTriangles {
  double low_m;
  std::uint8_t a, b;
};

// Certainly no triangle of one is nearer to one of the other [m]; +inf where one has none.
double lowerGap(const PosedTile& a, const PosedTile& b);

// Fills `near` with all pairs that are not certainly at least `needed_m` > 0 apart, the nearest
// first. Returns the least distance that is certain of all others; +inf: there is none.
double nearTriangles(const PosedTile& a, const PosedTile& b, double needed_m,
                     std::vector<NearTriangles>& near);

}  // namespace deformable_contact_monitor
