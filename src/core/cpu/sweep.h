// Stage `sweep`: which pairs of a cluster's triangles are candidates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cpu/cycle_data.h"
#include "core/cpu/interval_scan.h"
#include "core/cpu/sort.h"
#include "core/cpu/swept_screen.h"
#include "core/stopwatch.h"

namespace deformable_contact_monitor {

// Takes clusters through `sort`, `sweep` and `judge`, so that each is still in the cache; keeps its
// buffers from cluster to cluster. Gives up once the limit is over. One per thread and cycle.
// Hull: as in hull.h.
template <class Hull>
class ClusterSweeper {
 public:
  explicit ClusterSweeper(const CycleInput<Hull>& input)
      : input_(input), pace_(input.limit, kLook), sorter_(input), screen_(input), output_(input) {}
  ClusterSweeper(const ClusterSweeper&) = delete;
  ClusterSweeper& operator=(const ClusterSweeper&) = delete;

  void sweep(ClusterIndex cluster);

  CycleOutput<Hull>& output() { return output_; }

 private:
  void sweepGroups();
  void sweepWithin(const GroupRange& range);
  void sweepAcross(const GroupRange& rows, const GroupRange& columns, bool closed);
  bool owns(const BoxPair& pair) const;
  bool scan(std::uint32_t row, std::uint32_t begin, std::uint32_t end);
  void judgePairs();
  void judgeSome(BoxPair* pairs, std::size_t count);

  static constexpr std::uint64_t kLook = 1 << 17;  // columns between looks at the limit

  const CycleInput<Hull>& input_;
  PacedLimit pace_;
  ClusterSorter<Hull> sorter_;
  SortedCluster<Hull> sorted_;
  PairScreen<Hull> screen_;
  std::vector<BoxPair> pairs_;  // of which pair_count_ are in use
  std::size_t pair_count_ = 0;
  Screened<Hull> screened_;
  Stopwatch watch_;
  CycleOutput<Hull> output_;
};

}  // namespace deformable_contact_monitor
