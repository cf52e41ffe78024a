#include "core/common/scene_queries.h"

#include <map>
#include <stdexcept>
#include <utility>

#include "core/common/part_table.h"
#include "core/common/posed_body.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {
namespace {

bool listsWithinMargins(const Options& options) {
  return options.motion == Motion::kInstant && (options.near_pairs || !options.nearest);
}

}  // namespace

BodyGroups::BodyGroups(const Scene& scene) : group(scene.bodyCount()) {
  const auto count = static_cast<BodyId>(scene.bodyCount());
  std::map<std::vector<bool>, std::uint32_t> known;
  std::vector<BodyId> representative;
  for (BodyId a = 0; a < count; ++a) {
    std::vector<bool> row(count);
    for (BodyId b = 0; b < count; ++b) row[b] = scene.pairEnabled(a, b);
    const auto [place, added] =
        known.emplace(std::move(row), static_cast<std::uint32_t>(known.size()));
    group[a] = place->second;
    if (added) representative.push_back(a);
  }
  for (const BodyId a : representative) {
    std::vector<bool> row;
    row.reserve(representative.size());
    for (const BodyId b : representative) row.push_back(scene.pairEnabled(a, b));
    enabled.push_back(std::move(row));
  }
}

std::size_t trianglesThatTakePart(const Scene& scene) {
  std::size_t count = 0;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (scene.takesPart(id)) count += scene.body(id).mesh.triangleCount();
  }
  return count;
}

bool listsNearPairs(const Scene& scene, const Options& options) {
  return scene.anyMargin() && listsWithinMargins(options);
}

float listedMargin(const Body& body, const Options& options) {
  return listsWithinMargins(options) ? body.margin_m : 0;
}

void requireHostVertices(const Scene& scene, const std::string& backend) {
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (scene.takesPart(id)) requireHostVertices(scene.body(id), backend);
  }
}

void requireHostVertices(const Body& body, const std::string& backend) {
  if (!body.device_vertices) return;
  throw std::invalid_argument(body.name + ": its vertices are on a device, which backend \"" +
                              backend + "\" cannot read");
}

std::vector<RejectedTriangles> rejectedTriangles(const Scene& scene, Motion motion) {
  const PartTable parts(scene);
  std::vector<RejectedTriangles> rejected(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const Body& of = scene.body(id);
    const PosedBody now(of), earlier = PosedBody::earlier(of);
    const auto count = static_cast<std::uint32_t>(of.mesh.triangleCount());
    if (!of.parts.empty()) rejected[id].by_part.resize(std::size_t{of.listed_parts.back()} + 1);
    for (std::uint32_t t = 0; t < count; ++t) {
      if (!parts.takesPart(parts.of(id, t))) continue;
      bool is_rejected = false;
      for (const PosedBody* body : {&now, &earlier}) {
        if ((body == &earlier && motion == Motion::kInstant) || isFinite(body->triangle(t))) {
          continue;
        }
        is_rejected = true;
        rejected[id].by_pose = rejected[id].by_pose || isFinite(body->received(t));
      }
      if (!is_rejected) continue;
      ++rejected[id].count;
      if (!of.parts.empty()) ++rejected[id].by_part[of.parts[t]];
    }
  }
  return rejected;
}

}  // namespace deformable_contact_monitor
