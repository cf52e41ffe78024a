// Decides whether rejected triangles leave it open how a pair stands.
#include "monitor/state/rejected_sides.h"

#include <algorithm>
#include <cstddef>

namespace deformable_contact_monitor {
namespace {

// Returns why NONE and NEAR must not be claimed of something with so many rejected triangles; empty
// if the rules tolerate them.
std::string rejectsProblem(const std::string& name, std::uint64_t rejected, std::size_t triangles,
                           double tolerated_rejects, const char* where) {
  if (static_cast<double>(rejected) <= tolerated_rejects * static_cast<double>(triangles)) {
    return "";
  }
  return name + ": " + where + std::to_string(rejected) + " of " + std::to_string(triangles) +
         " triangles have a vertex that is not finite (tolerated_rejects)";
}

// Returns whether the part of one side of the pair is compared with anything of the other body.
bool takesPart(const Scene& scene, const MonitoredPair& pair, bool is_a, PartId part) {
  const BodyId id = is_a ? pair.a : pair.b, other = is_a ? pair.b : pair.a;
  const std::vector<PartId>& others = scene.body(other).listed_parts;
  return std::any_of(others.begin(), others.end(), [&](PartId of_other) {
    return scene.partPairEnabled(id, part, other, of_other);
  });
}

}  // namespace

std::string rejectsProblem(const CycleReport& report, const MonitoredPair& pair, bool is_a,
                           const Rejects& rejects, double tolerated) {
  const BodyStatus& body = report.bodies.at(is_a ? pair.a : pair.b);
  const Body& in_scene = report.scene->body(is_a ? pair.a : pair.b);
  const PartId part = is_a ? pair.part_a : pair.part_b;
  const auto problemOf = [&](PartId of) {
    return rejectsProblem(nameOf(body, of), rejects.by_part.empty() ? 0 : rejects.by_part.at(of),
                          body.parts->triangles.at(of), tolerated, rejects.where);
  };
  if (in_scene.parts.empty()) {
    if (body.partCount() > 0 && !takesPart(*report.scene, pair, is_a, 0)) {
      return body.name + ": " + body.parts->problem;
    }
    return rejectsProblem(body.name, rejects.all, in_scene.mesh.triangleCount(), tolerated,
                          rejects.where);
  }
  if (part != 0) return problemOf(part);
  std::string problem;
  for (const PartId of : in_scene.listed_parts) {
    if (!takesPart(*report.scene, pair, is_a, of)) continue;
    const std::string own = problemOf(of);
    if (own.empty() || of == 0) return own;
    if (problem.empty()) problem = own;
  }
  return problem;
}

}  // namespace deformable_contact_monitor
