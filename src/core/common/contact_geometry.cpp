#include "core/common/contact_geometry.h"

#include <cstddef>
#include <map>

#include "core/common/parallel.h"
#include "core/rules/geometry_of_pair.h"

namespace deformable_contact_monitor {

// It has a limit of its own: a list of contacts is complete without geometry, so a limit that is
// over here must not mark the cycle as cut off.
void writeGeometry(const Scene& scene, const Options& options, DetectionResult& result) {
  constexpr std::size_t kBlock = 256;  // about 0.3 ms of work
  if (!options.geometry) return;
  std::vector<PosedBody> bodies(scene.bodies().begin(), scene.bodies().end());
  const CycleLimit limit(options.limits);
  const TrianglePairs& contacts = result.contacts;
  resizeWithin(limit, contacts.size(), result.geometry);
  if (limit.wasOver()) {
    result.geometry.clear();
    return;
  }
  parallelBlocks(
      limit, contacts.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const TrianglePair& pair = contacts[i];
          result.geometry[i] =
              geometryOf(bodies[pair.body_a].triangle(pair.triangle_a),
                         bodies[pair.body_b].triangle(pair.triangle_b), result.separationM(i));
        }
      });
  if (limit.wasOver()) result.geometry.clear();
}

NearestPair nearestPairOf(const Scene& scene, const TrianglePair& pair, float distance_m) {
  const PosedBody a(scene.body(pair.body_a)), b(scene.body(pair.body_b));
  return nearestPairOf(a, b, pair, distance_m);
}

NearestPair nearestPairOf(const PosedBody& a, const PosedBody& b, const TrianglePair& pair,
                          float distance_m) {
  const PairGeometry geometry =
      geometryOf(a.triangle(pair.triangle_a), b.triangle(pair.triangle_b), distance_m);
  if (distance_m == 0) return {pair, 0, geometry.point_a, geometry.point_a, Vec3f()};
  return {pair, distance_m, geometry.point_a, geometry.point_b, geometry.normal};
}

std::vector<NearestPair> touchingPairs(const Scene& scene, const DetectionResult& result) {
  // Contacts are sorted by (body_a, triangle_a, body_b, triangle_b), so the first one of two bodies
  // is the least.
  const std::size_t bodies = scene.bodyCount();
  std::vector<const TrianglePair*> first(bodies * bodies);
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    const TrianglePair& pair = result.contacts[i];
    const TrianglePair*& known = first[bodies * pair.body_a + pair.body_b];
    if (known == nullptr && pair.body_a != pair.body_b && result.touches(i)) known = &pair;
  }
  std::vector<NearestPair> touching;
  for (const TrianglePair* pair : first) {
    if (pair != nullptr) touching.push_back(nearestPairOf(scene, *pair, 0));
  }
  return touching;
}

std::vector<NearestOfParts> touchingParts(const Scene& scene, const DetectionResult& result) {
  std::map<PartPair, TrianglePair> first;
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    const TrianglePair& pair = result.contacts[i];
    const Body &a = scene.body(pair.body_a), &b = scene.body(pair.body_b);
    const bool named = !a.parts.empty() || !b.parts.empty();
    if (pair.body_a == pair.body_b || !named || !result.touches(i)) continue;
    first.emplace(
        PartPair{pair.body_a, pair.body_b, a.partOf(pair.triangle_a), b.partOf(pair.triangle_b)},
        pair);
  }
  std::vector<NearestOfParts> touching;
  touching.reserve(first.size());
  for (const auto& [parts, pair] : first) {
    touching.push_back({parts, nearestPairOf(scene, pair, 0)});
  }
  return touching;
}

}  // namespace deformable_contact_monitor
