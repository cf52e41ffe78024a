// How many clusters a scene is worth.
#pragma once

#include <algorithm>
#include <cstddef>

namespace deformable_contact_monitor {

// What a backend likes best; found by measurement.
struct ClusterCountPolicy {
  std::size_t triangles_each;
  std::size_t most;
  std::size_t one_below;  // triangles below which one cluster does
  // From this many clusters on, a multiple of it: vectors or processors have equal shares.
  std::size_t multiple;
};

// For `triangles` in clusters. `asked`: how many the user wants, 0: as the scene asks for;
// `current`: how many there are, or 0. Keeps what is about right, for a new count costs new
// clusters.
inline std::size_t clusterCountFor(int asked, const ClusterCountPolicy& policy,
                                   std::size_t triangles, std::size_t current) {
  if (asked > 0) return std::min(static_cast<std::size_t>(asked), triangles);
  const std::size_t one_below = current > 1 ? policy.one_below / 2 : policy.one_below;
  if (triangles < one_below) return std::min<std::size_t>(triangles, 1);
  std::size_t wanted = std::min(policy.most, triangles / policy.triangles_each + 1);
  if (wanted > policy.multiple) wanted -= wanted % policy.multiple;
  return 3 * current > 2 * wanted && 2 * current < 3 * wanted ? current : wanted;
}

}  // namespace deformable_contact_monitor
