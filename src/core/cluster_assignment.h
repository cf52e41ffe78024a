// Every regular triangle into each cluster that it may share a contact in.
#pragma once

#include <cstdint>
#include <vector>

#include "core/large_triangles.h"
#include "core/prototypes.h"
#include "core/scene.h"
#include "core/working_set.h"

namespace deformable_contact_monitor {

struct ClusterAssignment {
  // Clusters of each regular triangle, ascending: clusters[list_begin[i] .. list_begin[i + 1]).
  std::vector<std::uint32_t> list_begin;
  std::vector<std::uint32_t> clusters;
  // Members of each cluster, as indices into the regular triangles, ascending:
  // members[member_begin[g] .. member_begin[g + 1]).
  std::vector<std::uint32_t> member_begin;
  std::vector<std::uint32_t> members;

  std::size_t clusterCount() const { return member_begin.size() - 1; }
};

class ClusterAssigner {
 public:
  // overlap in [0, 1]: the share of each triangle, about its centroid, that decides. Margins are
  // the bodies'.
  void assign(const Scene& scene, const WorkingSet& set, const SizeSplit& split,
              const Prototypes& prototypes, float overlap, ClusterAssignment& assignment);

 private:
  void findWinners(const WorkingSet& set, const SizeSplit& split, const PrototypesView& view,
                   const std::vector<float>& slack);

  std::vector<Vec3f> scaled_;         // per vertex that is in use
  std::vector<Winner> winners_;       // per vertex
  std::vector<std::uint32_t> owner_;  // per vertex: a body that uses it, or kUnused
};

// Slack of the half-space rule for each body [scaled]: twice its margin.
std::vector<float> scaledSlack(const Scene& scene, const SceneScale& scale);

}  // namespace deformable_contact_monitor
