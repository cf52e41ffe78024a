// What the contacts of a cycle sum up to, for each pair of bodies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "core/vector3.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

struct PairSummary {
  std::uint64_t count = 0;  // of triangle pairs
  // 0 where some touch, or minus the depth of the deepest if hasGeometry().
  double min_separation_m = std::numeric_limits<double>::infinity();
  Vec3d corner_sum;     // over six corners a triangle pair [m]
  Vec3d normal_sum;     // of body_a's distinct triangles, doubled areas [m^2]
  double area_sum = 0;  // of the same, to tell "cancels out" from "small"

  // Some triangle pair touches.
  bool touches() const { return count > 0 && min_separation_m <= 0; }
  // Mean over the triangle pairs of the mean of their six corners [m]; zero without a pair.
  Vec3d centroid() const;
  // Unit vector of body_a's triangles, weighted by area; zero where they cancel out.
  Vec3d meanNormal() const;
};

class PairSummaries {
 public:
  // On threads. Normals are summed up where body_a is a link: only links have a side that faces the
  // other body.
  explicit PairSummaries(const CycleReport& report) : PairSummaries(report, report.result) {}
  // The same of another result (null: nothing) of the report's scene.
  PairSummaries(const CycleReport& report, const DetectionResult* result);

  // Whether so many contacts are summed up on several threads.
  static bool isOnThreads(std::size_t contacts);

  // Empty if the two have no contact.
  PairSummary of(BodyId a, BodyId b) const;

 private:
  std::unordered_map<std::uint64_t, PairSummary> by_pair_;
};

}  // namespace deformable_contact_monitor
