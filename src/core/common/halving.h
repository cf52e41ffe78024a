// Divides triangles into parts by their places, halved again and again along the longest side.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/common/cycle_limit.h"
#include "core/predicates/aabb.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Holds a triangle of a mesh, and its place [m, body frame].
struct PlacedTriangle {
  Vec3f at;
  std::uint32_t triangle;
};

// Returns the axis along which the centroids' bounding box is longest.
inline int longestSide(const PlacedTriangle* first, const PlacedTriangle* last) {
  Aabb box;
  for (const PlacedTriangle* t = first; t != last; ++t) box.include(t->at);
  int longest = 0;
  for (int k = 1; k < 3; ++k) {
    if (box.max[k] - box.min[k] > box.max[longest] - box.min[longest]) longest = k;
  }
  return longest;
}

// Reorders triangles so that each run of `unit` of them, from the first on, lies close together.
// `middle` is a multiple of `unit`, so that all runs but the last are full.
inline void halve(const CycleLimit& limit, PlacedTriangle* first, PlacedTriangle* last,
                  std::size_t unit) {
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

}  // namespace deformable_contact_monitor
