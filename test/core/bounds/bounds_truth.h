// Distances of bodies by looking at all pairs of triangles.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/common/posed_body.h"
#include "core/predicates/aabb.h"
#include "core/predicates/triangle_distance.h"
#include "core/predicates/triangle_intersection.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Returns the distance of two triangles with finite vertices [m], with a relative error of at most
// 2^-28. It is 0 iff they intersect.
inline double trueDistance(const Triangle& a, const Triangle& b) {
  PredicateState state{Predicates::kExact};
  if (trianglesIntersect(a, b, state)) return 0;
  return std::max(separation(a, b), 1.4e-45);
}

inline std::vector<Triangle> finiteTriangles(const Body& body) {
  std::vector<Triangle> triangles;
  const PosedBody posed(body);
  for (std::uint32_t t = 0; t < body.mesh.triangleCount(); ++t) {
    if (isFinite(posed.triangle(t))) triangles.push_back(posed.triangle(t));
  }
  return triangles;
}

inline double trueDistance(const std::vector<Triangle>& a, const std::vector<Triangle>& b) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const Triangle& s : a) {
    for (const Triangle& t : b) {
      // Boxes alone: an independent filter, in double.
      if (std::sqrt(squaredGap(boxOf(s), boxOf(t))) * (1 - 1e-9) >= least_m) continue;
      least_m = std::min(least_m, trueDistance(s, t));
    }
  }
  return least_m;
}

}  // namespace deformable_contact_monitor
