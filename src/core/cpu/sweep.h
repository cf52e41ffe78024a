// Stage `sweep`: which pairs of a cluster's triangles are candidates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/stopwatch.h"
#include "core/cpu/cycle_data.h"
#include "core/cpu/interval_scan.h"
#include "core/cpu/sort.h"
#include "core/cpu/swept_filter.h"

namespace deformable_contact_monitor {

// What a row of the sweep found: columns up to `end` of all that were found, from where the row
// before ended.
struct FoundRow {
  SortedIndex row;
  std::size_t end;
};

// What a sweeper works in. One per thread, from cycle to cycle. Hull: as in hull.h, here and below.
template <class Hull>
struct alignas(kOwnLines) SweepBuffers {
  SortBuffers<Hull> sort;
  SortedCluster<Hull> sorted;
  std::vector<FoundRow> rows;
  std::vector<SortedIndex> found;
  std::vector<BoxPair> pairs;
  ScreenBuffers<Hull> screen;
  Screened<Hull> screened;
};

// Takes clusters through `sort`, `sweep` and `judge`, so that each is still in the cache. Gives up
// once the limit is over. One per thread and cycle.
template <class Hull>
class ClusterSweeper {
 public:
  ClusterSweeper(const CycleInput<Hull>& input, SweepBuffers<Hull>& buffers,
                 CycleOutput<Hull>& output)
      : input_(input),
        pace_(input.limit, kLook),
        sorter_(input, buffers.sort),
        sorted_(buffers.sorted),
        screen_(input, buffers.screen),
        rows_(buffers.rows),
        found_(buffers.found),
        pairs_(buffers.pairs),
        screened_(buffers.screened),
        output_(output) {}
  ClusterSweeper(const ClusterSweeper&) = delete;
  ClusterSweeper& operator=(const ClusterSweeper&) = delete;

  // Adds to the output.
  void sweep(ClusterIndex cluster);

 private:
  void sweepGroups();
  void sweepWithin(const GroupRange& range);
  void sweepAcross(const GroupRange& rows, const GroupRange& columns, bool closed);
  bool owns(SortedIndex a, SortedIndex b) const;
  bool scan(std::uint32_t row, std::uint32_t begin, std::uint32_t end);
  std::size_t pairsOfBoxes();
  void judgeFound();

  static constexpr std::uint64_t kLook = 1 << 17;  // columns between looks at the limit

  const CycleInput<Hull>& input_;
  PacedLimit pace_;
  ClusterSorter<Hull> sorter_;
  SortedCluster<Hull>& sorted_;
  PairScreen<Hull> screen_;
  std::vector<FoundRow>& rows_;
  std::vector<SortedIndex>& found_;  // of which found_count_ are in use
  std::size_t found_count_ = 0;
  std::vector<BoxPair>& pairs_;
  Screened<Hull>& screened_;
  Stopwatch watch_;
  CycleOutput<Hull>& output_;
};

}  // namespace deformable_contact_monitor
