// Pairs of regions of two bodies, and of their tiles, that may be near each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/bounds/body_tiles.h"

namespace deformable_contact_monitor {

// Regions or tiles of a first body and a second; certainly no nearer than low_m [m].
struct NearParts {
  double low_m;
  std::uint32_t a, b;
};

// Adds to `near` all pairs of region `region_a` of a with one of b that are not certainly at least
// `needed_m` > 0 apart, in the order of b's. Returns the least distance that is certain of all
// others; +inf: there is none.
double nearRegions(const BodyTiles& a, std::size_t region_a, const BodyTiles& b, double needed_m,
                   std::vector<NearParts>& near);

// Fills `near` with such pairs of tiles of two regions, in their order.
double nearTiles(const BodyTiles& a, std::size_t region_a, const BodyTiles& b, std::size_t region_b,
                 double needed_m, std::vector<NearParts>& near);

}  // namespace deformable_contact_monitor
