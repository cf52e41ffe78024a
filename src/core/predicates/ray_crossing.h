// Whether a ray crosses a triangle, with every tie decided.
#pragma once

#include "core/predicates/orientation.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// Whether the ray from p along +z crosses the triangle, as if p stood at (x + e, y + e^2, z) for an
// e > 0 smaller than any number: from there it meets no edge and no vertex, and no triangle that
// stands upright. While p is not on the triangle, p and that point are on the same side of it, so
// for a p that is on no triangle of a closed surface, the number of those crossed is odd iff it is
// inside. Finite input; exact.
inline bool crossesUpwards(const Vec3f& p, const Triangle& triangle, PredicateState& state) {
  constexpr int kUp = 2;
  bool is_beneath = false;
  for (int k = 0; k < 3; ++k) {
    // In the projection: a line from the moved point along +x, and an edge from `low` to `high`.
    const Vec3f& u = triangle.v[k];
    const Vec3f& v = triangle.v[(k + 1) % 3];
    if ((u.y > p.y) == (v.y > p.y)) continue;
    const Vec3f& low = u.y > p.y ? v : u;
    const Vec3f& high = u.y > p.y ? u : v;
    // On the edge: e moves the point to the right of it.
    if (orient2d(low, high, p, kUp, state) > 0) is_beneath = !is_beneath;
  }
  if (!is_beneath) return false;  // or above; so the projection has an area
  const Vec3f& a = triangle.v[0];
  const Vec3f& b = triangle.v[1];
  const Vec3f& c = triangle.v[2];
  return orient3d(a, b, c, p, state) * orient2d(a, b, c, kUp, state) < 0;
}

}  // namespace deformable_contact_monitor
