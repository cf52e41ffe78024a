// Patches of contacts as rviz markers.
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/analysis/contact_patches.h"
#include "monitor/cycle_report.h"
#include "monitor/markers/contact_markers.h"

namespace deformable_contact_monitor {

// One thread at a time.
class PatchMarkers {
 public:
  explicit PatchMarkers(MarkerOptions options) : options_(options) {}

  // Adds those of the cycle's patches (null: none were made) to an array of the same report, each
  // in the namespace "patch: <a>/<b>": its triangles outlined in a color of its own, an arrow from
  // its centroid along its normal, if it has one, and its id as a text, with ids that are stable
  // while the patch has its own. Of the cycle's pairs, what was drawn before and is not now is
  // deleted. Over max_triangles, each patch has as many of its triangles outlined as any other, at
  // most.
  void add(const CycleReport& report, const std::vector<Patch>* patches,
           visualization_msgs::MarkerArray* array);

 private:
  MarkerOptions options_;
  std::set<std::pair<std::string, std::int32_t>> drawn_;  // namespaces and ids
};

}  // namespace deformable_contact_monitor
