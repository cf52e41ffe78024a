// Stage `assign`: every regular triangle into each cluster that it may share a contact in.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/index.h"
#include "core/common/parallel.h"
#include "core/cpu/primitive.h"
#include "core/cpu/prototypes.h"
#include "core/cpu/size_split.h"
#include "core/cpu/transform.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// One triangle in one cluster, with all that the sweep needs of it in one place. Hull: as in
// hull.h, here and below.
template <class Hull>
struct ClusterMember {
  Hull posed;
  std::array<std::uint32_t, 3> vertex_id;
  TriangleIndex triangle;
  BodyIndex body;
  // The clusters that the triangle is in, ascending: lists[list_begin ... + list_size).
  std::uint32_t list_begin, list_size;
};

template <class Hull>
struct ClusterAssignment {
  std::vector<std::uint32_t> lists;
  // Members of cluster g, in ascending order of triangles: [member_begin[g], member_begin[g + 1]).
  std::vector<std::uint32_t> member_begin;
  std::vector<ClusterMember<Hull>> members;

  std::size_t clusterCount() const { return member_begin.size() - 1; }
  // Every triangle is at home in its lowest cluster alone.
  bool isHome(const ClusterMember<Hull>& member, ClusterIndex cluster) const {
    return lists[member.list_begin] == cluster.value;
  }
};

class ClusterAssigner {
 public:
  // overlap in [0, 1]: the share of each triangle, about its centroid, that decides. Margins, or
  // pads, are the bodies'. Where the limit was over, the assignment is of no use.
  template <class Hull>
  void assign(const Scene& scene, const WorkingSet& set, const SizeSplit& split,
              const Prototypes& prototypes, float overlap, ClusterAssignment<Hull>& assignment,
              const CycleLimit& limit = noLimit());

 private:
  // Lists of one block of triangles, to be joined in order.
  struct alignas(kOwnLines) Block {
    std::vector<std::uint32_t> length, lists;  // per triangle; joined
    std::vector<std::uint32_t> members;        // per cluster: how many; later: where they begin
  };

  void markUsers(const WorkingSet& set, const SizeSplit& split, const CycleLimit& limit);
  template <class Hull>
  void findNearest(const WorkingSet& set, const SizeSplit& split, const PrototypesView& view,
                   const std::vector<float>& slack, const CycleLimit& limit);
  template <class Hull>
  void assignBlock(const WorkingSet& set, const SizeSplit& split, const PrototypesView& view,
                   float overlap, const std::vector<float>& slack, std::size_t begin,
                   std::size_t end, const CycleLimit& limit, Block& block) const;
  bool countMembers(std::size_t cluster_count, const CycleLimit& limit,
                    std::vector<std::uint32_t>& member_begin);
  template <class Hull>
  void collectMembers(const WorkingSet& set, const SizeSplit& split, std::size_t cluster_count,
                      const CycleLimit& limit, ClusterAssignment<Hull>& assignment);

  std::vector<Block> blocks_;

  // Per state of a vertex, those of a vertex side by side:
  std::vector<Vec3f> scaled_;              // if it is in use
  std::vector<NearestPrototype> nearest_;  // from cycle to cycle, as guesses
  // Per vertex: the body that uses it, or kUnused.
  std::vector<std::atomic<std::uint32_t>> user_;
};

// Of each body [scaled].
template <class Hull = Triangle>
std::vector<float> scaledSlacks(const Scene& scene, const SceneScale& scale);

}  // namespace deformable_contact_monitor
