#include "core/cpu/sweep.h"

#include "core/cpu/narrow_phase.h"
#include "core/cpu/swept_narrow_phase.h"
#include "core/rules/deduplication.h"

namespace deformable_contact_monitor {

// The columns in [begin, end) whose intervals begin within the row's. False once the limit is over.
template <class Hull>
bool ClusterSweeper<Hull>::scan(std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
  if (begin == end) return true;
  const std::size_t room = found_count_ + (end - begin) + kScanChunk;
  if (found_.size() < room) found_.resize(2 * room);
  SortedIndex* const found = &found_[found_count_];
  const ScanRange range{sorted_.lo.data(), sorted_.hi[row], begin, end};
  ScanCounts counts;
  if constexpr (kIsMoving<Hull>) {
    counts = scanRow(SortedIndex(row), sorted_.packed(0), sorted_.packed(1), range, found);
  } else {
    counts = scanRow(SortedIndex(row), sorted_.packed(0), range, found);
  }
  output_.interval_overlaps += counts.overlaps;
  constexpr std::uint32_t kRow = 16;  // what a row costs beside its columns, in columns
  if (pace_.over(counts.overlaps + kRow)) return false;
  if (counts.found == 0) return true;
  found_count_ += counts.found;
  rows_.push_back({SortedIndex(row), found_count_});
  // Parts take a millisecond or two without their verdicts.
  constexpr std::size_t kPart = kIsMoving<Hull> ? 1 << 12 : 1 << 16;
  if (found_count_ >= kPart) judgeFound();
  return true;
}

// Each unordered pair once: the partner begins later in the order.
template <class Hull>
void ClusterSweeper<Hull>::sweepWithin(const GroupRange& range) {
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    if (!scan(i, i + 1, range.end)) return;
  }
}

// Pairs whose column begins within the row's interval; `closed`: also where both begin together.
template <class Hull>
void ClusterSweeper<Hull>::sweepAcross(const GroupRange& rows, const GroupRange& columns,
                                       bool closed) {
  const std::vector<float>& lo = sorted_.lo;
  std::uint32_t first = columns.begin;
  for (std::uint32_t i = rows.begin; i < rows.end; ++i) {
    while (first != columns.end && (closed ? lo[first] < lo[i] : lo[first] <= lo[i])) ++first;
    if (!scan(i, first, columns.end)) return;
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
bool ClusterSweeper<Hull>::owns(SortedIndex a, SortedIndex b) const {
  const LowerClusters lower_a = sorted_.lower[a.value], lower_b = sorted_.lower[b.value];
  if ((lower_a == kSeveralLower) | (lower_b == kSeveralLower)) {
    return ownsPair(sorted_.cluster.value, sorted_.clusters[a.value], sorted_.clusters[b.value]);
  }
  return (lower_a != lower_b) | (lower_a == kNoLower);
}

// Of what was found, the pairs that this cluster owns and whose boxes intersect: the first of
// pairs_ then. How many.
template <class Hull>
std::size_t ClusterSweeper<Hull>::pairsOfBoxes() {
  if (pairs_.size() <= found_count_) pairs_.resize(2 * found_count_ + 1);  // one is rubbish
  BoxPair* next = pairs_.data();
  std::size_t i = 0;
  for (const FoundRow& row : rows_) {
    const auto box = sorted_.boxes[row.row.value];
    const bool owns_all = sorted_.lower[row.row.value] == kNoLower;
    for (; i < row.end; ++i) {
      const SortedIndex column = found_[i];
      *next = {row.row, column};
      next += intersects(box, sorted_.boxes[column.value]) & (owns_all || owns(row.row, column));
    }
  }
  return static_cast<std::size_t>(next - pairs_.data());
}

// What was found since this was last called: boxes, owner and plane filters end the sweep, then
// come the verdicts.
template <class Hull>
void ClusterSweeper<Hull>::judgeFound() {
  screened_.clear();
  const std::size_t pairs = pairsOfBoxes();  // moves pairs_
  screen_.screen(sorted_.triangles, pairs_.data(), pairs, screened_);
  rows_.clear();
  found_count_ = 0;
  output_.work.add(Stage::kSweep, watch_.lapMs());
  judgeCandidates(input_, screened_, output_);
  output_.work.add(Stage::kNarrowPhase, watch_.lapMs());
}

template <class Hull>
void ClusterSweeper<Hull>::sweep(ClusterIndex cluster) {
  const std::vector<std::uint32_t>& begin = input_.assignment.member_begin;
  if (begin[cluster.value] == begin[cluster.value + 1]) return;
  watch_ = Stopwatch();
  rows_.clear();
  found_count_ = 0;
  const bool is_sorted = sorter_.sort(cluster, sorted_);
  output_.work.add(Stage::kSort, watch_.lapMs());
  if (!is_sorted) return;
  sweepGroups();
  if (!input_.limit.over()) judgeFound();
}

template class ClusterSweeper<Triangle>;
template class ClusterSweeper<MovingTriangle>;

}  // namespace deformable_contact_monitor
