// Decides whether a ray crosses a triangle, with every tie resolved. Used to find out whether a
// point is inside a closed surface.
#pragma once

#include "core/predicates/orientation.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// Returns whether the ray from p along +z crosses the triangle, as if p stood at (x + e, y + e^2,
// z) for an e > 0 that is smaller than any number. From there the ray meets no edge, no vertex and
// no upright triangle ("simulation of simplicity", Edelsbrunner and Muecke 1990). If p is not on
// the triangle, p and that point are on the same side of it. So for a p that is on no triangle of a
// closed surface, the number of crossed triangles is odd iff p is inside. Input must be finite; the
// result is exact.
inline bool crossesUpwards(const Vec3f& p, const Triangle& triangle, PredicateState& state) {
  constexpr int kUp = 2;
  bool is_beneath = false;
  for (int k = 0; k < 3; ++k) {
    // Compares, in the projection along z, a line from the moved point along +x with the edge from
    // `low` to `high`.
    const Vec3f& u = triangle.v[k];
    const Vec3f& v = triangle.v[(k + 1) % 3];
    if ((u.y > p.y) == (v.y > p.y)) continue;
    const Vec3f& low = u.y > p.y ? v : u;
    const Vec3f& high = u.y > p.y ? u : v;
    // If p is on the edge, e moves it to the right of it.
    if (orient2d(low, high, p, kUp, state) > 0) is_beneath = !is_beneath;
  }
  if (!is_beneath) return false;  // or above; so the projection has an area
  const Vec3f& a = triangle.v[0];
  const Vec3f& b = triangle.v[1];
  const Vec3f& c = triangle.v[2];
  return orient3d(a, b, c, p, state) * orient2d(a, b, c, kUp, state) < 0;
}

}  // namespace deformable_contact_monitor
