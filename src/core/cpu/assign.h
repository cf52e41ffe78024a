// Stage `assign`: puts every regular triangle into each cluster in which it may have a contact.
//
// First the nearest prototype of each vertex is found, then the half-space rule
// (rules/half_space.h) lists a triangle's clusters, and a counting sort gathers the entries of each
// cluster. Blocks of triangles run on several threads; their results are joined in order.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/index.h"
#include "core/common/parallel.h"
#include "core/cpu/cluster.h"
#include "core/cpu/primitive.h"
#include "core/cpu/size_split.h"
#include "core/cpu/transform.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// One triangle in one cluster, with all that the later stages need of it side by side in memory.
template <class Primitive>
struct ClusterEntry {
  Primitive posed;
  std::array<std::uint32_t, 3> vertex_id;
  TriangleIndex triangle;
  BodyIndex body;
  // The triangle's clusters, ascending: lists[list_begin ... list_begin + list_size).
  std::uint32_t list_begin, list_size;
};

// The clusters of all regular triangles, and the entries of all clusters.
template <class Primitive>
struct ClusterAssignment {
  std::vector<std::uint32_t> lists;
  // The entries of cluster g, in ascending order of triangles: [entry_begin[g], entry_begin[g +
  // 1]).
  std::vector<std::uint32_t> entry_begin;
  std::vector<ClusterEntry<Primitive>> entries;

  std::size_t clusterCount() const { return entry_begin.size() - 1; }
  // Returns whether `cluster` is the lowest one of the entry's triangle. Each triangle has exactly
  // one such entry, so that loops over all triangles can use the entries.
  bool isHome(const ClusterEntry<Primitive>& entry, ClusterIndex cluster) const {
    return lists[entry.list_begin] == cluster.value;
  }
};

// Fills ClusterAssignments. It keeps its buffers from cycle to cycle.
class ClusterAssigner {
 public:
  // Fills in `assignment`. options.overlap in [0, 1] is the part of each triangle, about its
  // centroid, that the rule uses; less than 1 may lose contacts. Margins and motion bounds are
  // those of the bodies. Once the limit is over, the assignment is unspecified. `nearest` gets the
  // nearest prototype of each vertex in each state; what it has from an earlier cycle is the first
  // guess, which only saves time.
  template <class Primitive>
  void assign(const Scene& scene, const WorkingSet& set, const SizeSplit& split,
              const Prototypes& prototypes, const Options& options,
              std::vector<NearestPrototype>& nearest, ClusterAssignment<Primitive>& assignment,
              const CycleLimit& limit = noLimit());

 private:
  // The clusters of one block of triangles.
  struct alignas(kOwnLines) Block {
    std::vector<std::uint32_t> length, lists;  // per triangle; joined
    std::vector<std::uint32_t> entries;        // per cluster: how many; later: where they begin
  };

  void markUsers(const WorkingSet& set, const SizeSplit& split, const CycleLimit& limit);
  template <class Primitive>
  void findNearest(const WorkingSet& set, const SizeSplit& split, const PrototypesView& view,
                   const std::vector<float>& slack, const CycleLimit& limit,
                   std::vector<NearestPrototype>& nearest);
  template <class Primitive>
  void assignBlock(const WorkingSet& set, const SizeSplit& split, const PrototypesView& view,
                   float overlap, const std::vector<float>& slack,
                   const std::vector<NearestPrototype>& nearest, std::size_t begin, std::size_t end,
                   const CycleLimit& limit, Block& block) const;
  bool countEntries(std::size_t cluster_count, const CycleLimit& limit,
                    std::vector<std::uint32_t>& entry_begin);
  template <class Primitive>
  void collectEntries(const WorkingSet& set, const SizeSplit& split, std::size_t cluster_count,
                      const CycleLimit& limit, ClusterAssignment<Primitive>& assignment);

  std::vector<Block> blocks_;

  // Per state of a vertex that is in use; the states of a vertex are neighbours.
  std::vector<Vec3f> scaled_;
  // Per vertex: the body that uses it, or kUnused.
  std::vector<std::atomic<std::uint32_t>> user_;
};

// Returns the slack of the half-space rule for each body [scaled].
template <class Primitive = Triangle>
std::vector<float> scaledSlacks(const Scene& scene, const Options& options,
                                const SceneScale& scale);

}  // namespace deformable_contact_monitor
