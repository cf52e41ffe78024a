#include "core/bounds/distance_search.h"

#include <cmath>
#include <optional>
#include <vector>

#include "core/common/contact_geometry.h"
#include "core/common/posed_body.h"
#include "core/predicates/aabb.h"
#include "core/predicates/triangle_distance.h"
#include "core/predicates/triangle_intersection.h"
#include "core/rules/margins.h"
#include "core/rules/nearest.h"

namespace deformable_contact_monitor {
namespace {

// A triangle with finite vertices and its box, in the scene frame.
struct BoxedTriangle {
  std::uint32_t index;
  Triangle hull;
  Aabb box;
};

std::vector<BoxedTriangle> boxedTriangles(const Body& body) {
  std::vector<BoxedTriangle> triangles;
  const PosedBody posed(body);
  for (std::uint32_t t = 0; t < body.mesh.triangleCount(); ++t) {
    const Triangle hull = posed.triangle(t);
    if (isFinite(hull)) triangles.push_back({t, hull, boxOf(hull)});
  }
  return triangles;
}

std::optional<PairDistance> nearestOf(const std::vector<BoxedTriangle>& of_a,
                                      const std::vector<BoxedTriangle>& of_b, float margin_m,
                                      const CycleLimit& limit) {
  PairDistance best{margin_m, ~std::uint32_t{0}, ~std::uint32_t{0}};
  bool found = false;
  PacedLimit pace(limit, 512);
  for (const BoxedTriangle& a : of_a) {
    for (const BoxedTriangle& b : of_b) {
      if (pace.over()) return std::nullopt;
      const double reach_m = best.distance_m * (1 + 1e-6) + 0x1p-149;
      if (squaredGap(a.box, b.box) > reach_m * reach_m) continue;
      PredicateState state{Predicates::kExact};
      const float distance_m = trianglesIntersect(a.hull, b.hull, state)
                                   ? 0
                                   : comparedDistance(separation(a.hull, b.hull));
      const PairDistance pair{distance_m, a.index, b.index};
      if (!pair.precedes(best)) continue;
      best = pair;
      found = true;
    }
  }
  return found ? std::optional(best) : std::nullopt;
}

}  // namespace

void DistanceSearch::find(const Scene& scene, const Options& options, const CycleLimit& limit,
                          DetectionResult& result) {
  if (!options.nearest) return;
  std::vector<std::vector<BoxedTriangle>> bodies(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (scene.takesPart(id)) bodies[id] = boxedTriangles(scene.body(id));
  }
  for (const auto& [a, b] : scene.enabledPairs()) {
    if (a == b) continue;
    const float margin_m = pairMargin(scene.body(a).margin_m, scene.body(b).margin_m);
    const auto best = nearestOf(bodies[a], bodies[b], margin_m, limit);
    if (!best) continue;
    result.nearest.push_back(
        nearestPairOf(scene, {a, best->triangle_a, b, best->triangle_b}, best->distance_m));
  }
}

}  // namespace deformable_contact_monitor
