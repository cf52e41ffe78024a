#include "core/cpu/sweep.h"

#include <algorithm>

#include "core/cpu/judge.h"
#include "core/cpu/swept_judge.h"
#include "core/parallel.h"
#include "core/rules/ownership.h"

namespace deformable_contact_monitor {

// False once the limit is over.
template <class Hull>
bool ClusterSweeper<Hull>::scan(std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
  constexpr std::uint32_t kRow = 16;  // what a row costs beside its columns, in columns
  if (pace_.over(end - begin + kRow)) return false;
  if (begin == end) return true;
  output_.interval_overlaps += end - begin;
  const std::size_t room = pair_count_ + (end - begin) + kScanChunk;
  if (pairs_.size() < room) pairs_.resize(2 * room);
  BoxPair* const found = &pairs_[pair_count_];
  if constexpr (kIsMoving<Hull>) {
    pair_count_ +=
        scanRow(SortedIndex(row), sorted_.packed(0), sorted_.packed(1), begin, end, found);
  } else {
    pair_count_ += scanRow(SortedIndex(row), sorted_.packed(0), begin, end, found);
  }
  constexpr std::size_t kMostPairs = 1 << 18;  // bounds the memory of dense clusters
  if (pair_count_ > kMostPairs) judgePairs();
  return true;
}

// Each unordered pair once: the partner begins later in the order.
template <class Hull>
void ClusterSweeper<Hull>::sweepWithin(const GroupRange& range) {
  const std::vector<float>& lo = sorted_.lo;
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const auto last = std::upper_bound(lo.begin() + i + 1, lo.begin() + range.end, sorted_.hi[i]);
    if (!scan(i, i + 1, static_cast<std::uint32_t>(last - lo.begin()))) return;
  }
}

// Pairs whose column begins within the row's interval; `closed`: also where both begin together.
template <class Hull>
void ClusterSweeper<Hull>::sweepAcross(const GroupRange& rows, const GroupRange& columns,
                                       bool closed) {
  const std::vector<float>& lo = sorted_.lo;
  const auto columns_end = lo.begin() + columns.end;
  auto first = lo.begin() + columns.begin;
  for (std::uint32_t i = rows.begin; i < rows.end; ++i) {
    while (first != columns_end && (closed ? *first < lo[i] : *first <= lo[i])) ++first;
    const auto last = std::upper_bound(first, columns_end, sorted_.hi[i]);
    if (!scan(i, static_cast<std::uint32_t>(first - lo.begin()),
              static_cast<std::uint32_t>(last - lo.begin()))) {
      return;
    }
  }
}

template <class Hull>
void ClusterSweeper<Hull>::sweepGroups() {
  const std::vector<GroupRange>& groups = sorted_.groups;
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const std::vector<bool>& enabled = input_.groups.enabled[groups[s].group];
    if (enabled[groups[s].group]) sweepWithin(groups[s]);
    for (std::size_t t = s + 1; t < groups.size(); ++t) {
      if (!enabled[groups[t].group]) continue;
      sweepAcross(groups[s], groups[t], true);
      sweepAcross(groups[t], groups[s], false);
    }
  }
}

// Whether the swept cluster is the one that reports the pair.
template <class Hull>
bool ClusterSweeper<Hull>::owns(const BoxPair& pair) const {
  const LowerClusters a = sorted_.lower[pair.a.value], b = sorted_.lower[pair.b.value];
  if ((a == kSeveralLower) | (b == kSeveralLower)) {
    return ownsPair(sorted_.cluster.value, sorted_.clusters[pair.a.value],
                    sorted_.clusters[pair.b.value]);
  }
  return (a != b) | (a == kNoLower);
}

// What was found so far, in parts that take a millisecond or two without their verdicts.
template <class Hull>
void ClusterSweeper<Hull>::judgePairs() {
  constexpr std::size_t kPart = kIsMoving<Hull> ? 1 << 12 : 1 << 16;
  serialBlocks(input_.limit, pair_count_, kPart, [this](std::size_t begin, std::size_t end) {
    judgeSome(&pairs_[begin], end - begin);
  });
  pair_count_ = 0;
}

// Boxes, owner and plane filters end the sweep, then come the verdicts. Leaves rubbish in `pairs`.
template <class Hull>
void ClusterSweeper<Hull>::judgeSome(BoxPair* pairs, std::size_t count) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const BoxPair pair = pairs[i];
    pairs[kept] = pair;
    kept += intersects(sorted_.boxes[pair.a.value], sorted_.boxes[pair.b.value]) & owns(pair);
  }
  screened_.clear();
  screen_.screen(sorted_.triangles, pairs, kept, screened_);
  output_.work.add(Stage::kSweep, watch_.lapMs());
  judgeCandidates(input_, screened_, output_);
  output_.work.add(Stage::kJudge, watch_.lapMs());
}

template <class Hull>
void ClusterSweeper<Hull>::sweep(ClusterIndex cluster) {
  const std::vector<std::uint32_t>& begin = input_.assignment.member_begin;
  if (begin[cluster.value] == begin[cluster.value + 1]) return;
  watch_ = Stopwatch();
  const bool is_sorted = sorter_.sort(cluster, sorted_);
  output_.work.add(Stage::kSort, watch_.lapMs());
  if (!is_sorted) return;
  sweepGroups();
  judgePairs();
}

template class ClusterSweeper<Triangle>;
template class ClusterSweeper<MovingTriangle>;

}  // namespace deformable_contact_monitor
