// Sums up the contacts of a cycle for each pair of bodies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <unordered_map>
#include <vector>

#include "core/detector.h"
#include "core/vector3.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// The contacts of one pair of bodies. Vectors are in the scene frame.
struct PairSummary {
  std::uint64_t count =
      0;  // triangle pairs that touch, or are within the margin if those are listed
  // [m]; 0 if some touch, or minus the depth of the deepest pair if hasGeometry().
  double min_separation_m = std::numeric_limits<double>::infinity();
  // Contacts of the result, by their place in the list: the one at the least distance, and the
  // deepest one by its geometry, with these distances [m]; of several, the first. No contact: the
  // distance is infinite.
  std::size_t nearest = 0, deepest = 0;
  double nearest_m = std::numeric_limits<double>::infinity();
  double deepest_m = std::numeric_limits<double>::infinity();
  Vec3d corner_sum;     // over the six corners of each triangle pair [m]
  Vec3d normal_sum;     // of the distinct triangles of body_a, with length 2 * area [m^2]
  double area_sum = 0;  // of the lengths in normal_sum; tells a cancelled sum from a small one

  // Returns whether some triangle pair touches.
  bool touches() const { return count > 0 && min_separation_m <= 0; }
  // Returns the mean over all triangle pairs of the mean of their corners [m]; zero without a pair.
  Vec3d centroid() const;
  // Returns the area-weighted mean normal of body_a's triangles; zero where normals cancel out.
  Vec3d meanNormal() const;
};

// Returns the pair's bodies and parts as a key.
inline PartPair partKey(const MonitoredPair& pair) {
  return {pair.a, pair.b, pair.part_a, pair.part_b};
}

// Calls function(PartPair) for each of CycleReport::part_pairs that a pair of triangles belongs to.
template <class Function>
void forEachPartPair(const CycleReport& report, const TrianglePair& pair,
                     const Function& function) {
  const auto hasPart = [&report](BodyId id, std::uint32_t triangle, std::size_t part) {
    const std::vector<PartId>& pieces = report.scene->body(id).parts;
    return !pieces.empty() &&
           report.bodies.at(id).parts->has(static_cast<PartId>(part), pieces[triangle]);
  };
  const auto [a, triangle_a, b, triangle_b] = pair;
  const bool is_self = a == b;
  for (std::size_t part = 1; !is_self && part <= report.bodies.at(a).partCount(); ++part) {
    if (hasPart(a, triangle_a, part)) function(PartPair{a, b, static_cast<PartId>(part), 0});
  }
  for (std::size_t part = 1; part <= report.bodies.at(b).partCount(); ++part) {
    if (hasPart(b, triangle_b, part) || (is_self && hasPart(a, triangle_a, part))) {
      function(PartPair{a, b, 0, static_cast<PartId>(part)});
    }
  }
}

// The summaries of all pairs of bodies in one result.
class PairSummaries {
 public:
  // Sums up the contacts of a result (null: none) in the report's scene, on several threads if
  // there are many. Normals are summed up only if body_a is a link, because only the surface of a
  // link has an outer side that faces the other body.
  PairSummaries(const CycleReport& report, const DetectionResult* result);

  // Returns an empty summary if the two bodies have no contact.
  PairSummary of(BodyId a, BodyId b) const;
  // Does the same for a pair of the report's pairs or part_pairs.
  PairSummary of(const MonitoredPair& pair) const;

 private:
  std::unordered_map<std::uint64_t, PairSummary> by_pair_;
  std::map<PartPair, PairSummary> by_part_;
};

}  // namespace deformable_contact_monitor
