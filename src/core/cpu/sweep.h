// Stage `sweep`: finds which pairs of a cluster's triangles may be in contact.
//
// ClusterSweeper takes one cluster at a time through `sort`, `sweep` and `narrow_phase`, so that
// its data is still in the cache. A row is one triangle; its columns are the triangles whose
// intervals begin within the row's interval. Columns end up in these tests, from cheap to
// expensive: quantised boxes, boxes in the scene frame, the deduplication rule, the pairs of parts
// if they matter, and the float32 filters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/stopwatch.h"
#include "core/cpu/filter.h"
#include "core/cpu/interval_scan.h"
#include "core/cpu/pair_stages.h"
#include "core/cpu/sort.h"

namespace deformable_contact_monitor {

// The columns that a row of the sweep found: those up to `end` in the list of all found columns,
// from where the row before ended.
struct FoundRow {
  SortedIndex row;
  std::size_t end;
};

// Working memory of a sweeper. There is one per thread, kept from cycle to cycle.
template <class Primitive>
struct alignas(kOwnLines) SweepBuffers {
  SortBuffers<Primitive> sort;
  SortedCluster<Primitive> sorted;
  std::vector<FoundRow> rows;
  std::vector<SortedIndex> found;
  std::vector<BoxPair> pairs;
  FilterBuffers<Primitive> filter;
  FilteredPairs<Primitive> filtered;
};

// Takes clusters through `sort`, `sweep` and `narrow_phase`. It stops early once the limit is over.
// There is one per thread and cycle.
template <class Primitive>
class ClusterSweeper {
 public:
  ClusterSweeper(const CycleInput<Primitive>& input, SweepBuffers<Primitive>& buffers,
                 CycleOutput<Primitive>& output)
      : input_(input),
        pace_(input.limit, kPollPeriod),
        sorter_(input, buffers.sort),
        sorted_(buffers.sorted),
        filter_(input, buffers.filter),
        rows_(buffers.rows),
        found_(buffers.found),
        pairs_(buffers.pairs),
        filtered_(buffers.filtered),
        output_(output) {}
  ClusterSweeper(const ClusterSweeper&) = delete;
  ClusterSweeper& operator=(const ClusterSweeper&) = delete;

  // Sweeps one cluster, and adds to the output.
  void sweep(ClusterIndex cluster);

 private:
  void sweepGroups();
  void sweepWithin(const GroupRange& range);
  void sweepAcross(const GroupRange& rows, const GroupRange& columns, bool closed);
  bool reports(SortedIndex a, SortedIndex b) const;
  bool scan(std::uint32_t row, std::uint32_t begin, std::uint32_t end);
  std::size_t pairsOfBoxes();
  std::size_t dropDisabledParts(std::size_t pairs);
  void decideFound();

  static constexpr std::uint64_t kPollPeriod = 1 << 17;  // columns between two checks of the limit

  const CycleInput<Primitive>& input_;
  PacedLimit pace_;
  ClusterSorter<Primitive> sorter_;
  SortedCluster<Primitive>& sorted_;
  PairFilter<Primitive> filter_;
  std::vector<FoundRow>& rows_;
  std::vector<SortedIndex>& found_;  // the first found_count_ are in use
  std::size_t found_count_ = 0;
  std::vector<BoxPair>& pairs_;
  FilteredPairs<Primitive>& filtered_;
  Stopwatch watch_;
  CycleOutput<Primitive>& output_;
};

}  // namespace deformable_contact_monitor
