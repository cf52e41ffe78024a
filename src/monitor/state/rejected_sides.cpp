// Decides whether rejected triangles leave it open how a pair stands.
#include "monitor/state/rejected_sides.h"

#include <algorithm>
#include <cstddef>

namespace deformable_contact_monitor {
namespace {

// Returns why NONE and NEAR must not be claimed of something with so many rejected triangles; empty
// if the rules tolerate them.
std::string rejectsProblem(std::uint64_t rejected, std::size_t triangles,
                           double tolerated_rejects) {
  if (static_cast<double>(rejected) <= tolerated_rejects * static_cast<double>(triangles)) {
    return "";
  }
  return std::to_string(rejected) + " of " + std::to_string(triangles) +
         " triangles have a vertex that is not finite (tolerated_rejects)";
}

std::string of(const std::string& name, const Rejects& rejects, const std::string& problem) {
  return problem.empty() ? "" : name + ": " + rejects.where + problem;
}

// Answers about one side of a pair: which pieces of its body are compared with anything of the
// other body, and how much of a part was rejected.
class Side {
 public:
  Side(const CycleReport& report, const MonitoredPair& pair, bool is_a)
      : scene_(*report.scene),
        body_(report.bodies.at(is_a ? pair.a : pair.b)),
        other_body_(report.bodies.at(is_a ? pair.b : pair.a)),
        id_(is_a ? pair.a : pair.b),
        other_(is_a ? pair.b : pair.a),
        other_part_(is_a ? pair.part_b : pair.part_a) {}

  bool takesPart(PartId piece) const {
    const std::vector<PartId>& others = scene_.body(other_).listed_parts;
    return std::any_of(others.begin(), others.end(), [&](PartId of_other) {
      return (other_part_ == 0 || other_body_.parts->has(other_part_, of_other)) &&
             scene_.partPairEnabled(id_, piece, other_, of_other);
    });
  }

  // Returns the pieces of a part that have triangles and take part; of part 0, piece 0 alone.
  std::vector<PartId> piecesOf(PartId part) const {
    std::vector<PartId> pieces;
    for (const PartId piece : scene_.body(id_).listed_parts) {
      const bool is_of_part = part == 0 ? piece == 0 : body_.parts->has(part, piece);
      if (is_of_part && takesPart(piece)) pieces.push_back(piece);
    }
    return pieces;
  }

  std::string problemOf(PartId part, const Rejects& rejects, double tolerated) const {
    std::uint64_t rejected = 0;
    std::size_t triangles = 0;
    for (const PartId piece : piecesOf(part)) {
      rejected += rejects.by_part.empty() ? 0 : rejects.by_part.at(piece);
      triangles += body_.parts->triangles.at(piece);
    }
    return of(nameOf(body_, part), rejects, rejectsProblem(rejected, triangles, tolerated));
  }

 private:
  const Scene& scene_;
  const BodyStatus &body_, &other_body_;
  const BodyId id_, other_;
  const PartId other_part_;
};

}  // namespace

std::string rejectsProblem(const CycleReport& report, const MonitoredPair& pair, bool is_a,
                           const Rejects& rejects, double tolerated) {
  const BodyStatus& body = report.bodies.at(is_a ? pair.a : pair.b);
  const Body& in_scene = report.scene->body(is_a ? pair.a : pair.b);
  const PartId part = is_a ? pair.part_a : pair.part_b;
  const Side side(report, pair, is_a);
  if (in_scene.parts.empty()) {
    if (body.partCount() > 0 && !side.takesPart(0)) return body.name + ": " + body.parts->problem;
    return of(body.name, rejects,
              rejectsProblem(rejects.all, in_scene.mesh.triangleCount(), tolerated));
  }
  // Two parts have no state of their own, so this one stands for all parts.
  const bool needs_all = part == 0 && (is_a ? pair.part_b : pair.part_a) != 0 && rejects.all > 0;
  const bool has_own = part != 0 || !side.piecesOf(0).empty();
  std::string problem = has_own ? side.problemOf(part, rejects, tolerated) : "";
  if (has_own && (!needs_all || !problem.empty())) return problem;
  bool some_known = has_own;
  for (std::size_t i = 1; i <= body.partCount(); ++i) {
    const auto other = static_cast<PartId>(i);
    if (side.piecesOf(other).empty()) continue;
    std::string own = side.problemOf(other, rejects, tolerated);
    if (own.empty() && !needs_all) return "";
    if (!own.empty() && needs_all) return own;
    some_known |= own.empty();
    if (problem.empty()) problem = own;
  }
  if (some_known) return "";
  // Nothing is compared, because the triangles of the parts are not known.
  const bool is_unknown = body.parts != nullptr && !body.parts->problem.empty();
  return problem.empty() && is_unknown ? body.name + ": " + body.parts->problem : problem;
}

std::string whyUnknown(const CycleReport& report, BodyId id, double tolerated_rejects) {
  const BodyStatus& body = report.bodies.at(id);
  const Body& in_scene = report.scene->body(id);
  if (!body.unknown_because.empty() || !in_scene.parts.empty()) return body.unknown_because;
  return rejectsProblem(body.rejected, in_scene.mesh.triangleCount(), tolerated_rejects);
}

}  // namespace deformable_contact_monitor
