#include "core/cpu/sweep.h"

#include "core/rules/deduplication.h"

namespace deformable_contact_monitor {

// Scans the columns in [begin, end) whose intervals begin within the row's. Returns false once the
// limit is over.
template <class Primitive>
bool ClusterSweeper<Primitive>::scan(std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
  if (begin == end) return true;
  const std::size_t room = found_count_ + (end - begin) + kScanChunk;
  if (found_.size() < room) found_.resize(2 * room);
  SortedIndex* const found = &found_[found_count_];
  const ScanRange range{sorted_.lo.data(), sorted_.hi[row], begin, end};
  ScanCounts counts;
  if constexpr (kIsMoving<Primitive>) {
    counts = scanRow(SortedIndex(row), sorted_.packed(0), sorted_.packed(1), range, found);
  } else {
    counts = scanRow(SortedIndex(row), sorted_.packed(0), range, found);
  }
  output_.counters.interval_overlaps += counts.overlaps;
  constexpr std::uint32_t kRow = 16;  // what a row costs in addition to its columns, in columns
  if (pace_.over(counts.overlaps + kRow)) return false;
  if (counts.found == 0) return true;
  found_count_ += counts.found;
  rows_.push_back({SortedIndex(row), found_count_});
  // A part of this size takes a millisecond or two, without its verdicts.
  constexpr std::size_t kPart = kIsMoving<Primitive> ? 1 << 12 : 1 << 16;
  if (found_count_ >= kPart) decideFound();
  return true;
}

// Sweeps one group against itself. Each unordered pair comes up once, because the partner begins
// later in the order.
template <class Primitive>
void ClusterSweeper<Primitive>::sweepWithin(const GroupRange& range) {
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    if (!scan(i, i + 1, range.end)) return;
  }
}

// Sweeps the pairs whose column begins within the row's interval. With `closed`, both may begin at
// the same place; only one of the two directions of a pair of groups is closed.
template <class Primitive>
void ClusterSweeper<Primitive>::sweepAcross(const GroupRange& rows, const GroupRange& columns,
                                            bool closed) {
  const std::vector<float>& lo = sorted_.lo;
  std::uint32_t first = columns.begin;
  for (std::uint32_t i = rows.begin; i < rows.end; ++i) {
    while (first != columns.end && (closed ? lo[first] < lo[i] : lo[first] <= lo[i])) ++first;
    if (!scan(i, first, columns.end)) return;
  }
}

// Sweeps each enabled pair of body groups. Disabled pairs of bodies are never visited.
template <class Primitive>
void ClusterSweeper<Primitive>::sweepGroups() {
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

// Returns whether the swept cluster is the one that reports the pair. Two triangles may be together
// in several clusters.
template <class Primitive>
bool ClusterSweeper<Primitive>::reports(SortedIndex a, SortedIndex b) const {
  const LowerClusters lower_a = sorted_.lower[a.value], lower_b = sorted_.lower[b.value];
  if ((lower_a == kSeveralLower) | (lower_b == kSeveralLower)) {
    return reportsPair(sorted_.cluster.value, sorted_.clusters[a.value], sorted_.clusters[b.value]);
  }
  return (lower_a != lower_b) | (lower_a == kNoLower);
}

// Moves the pairs that this cluster reports and whose boxes intersect to the front of pairs_, and
// returns their number. It writes every pair and advances only past the kept ones, so that there is
// no branch.
template <class Primitive>
std::size_t ClusterSweeper<Primitive>::pairsOfBoxes() {
  if (pairs_.size() <= found_count_)
    pairs_.resize(2 * found_count_ + 1);  // the last write may be a dropped pair
  BoxPair* next = pairs_.data();
  std::size_t i = 0;
  for (const FoundRow& row : rows_) {
    const auto box = sorted_.boxes[row.row.value];
    const bool reports_all = sorted_.lower[row.row.value] == kNoLower;
    for (; i < row.end; ++i) {
      const SortedIndex column = found_[i];
      *next = {row.row, column};
      next +=
          intersects(box, sorted_.boxes[column.value]) & (reports_all || reports(row.row, column));
    }
  }
  return static_cast<std::size_t>(next - pairs_.data());
}

// Moves the pairs whose parts are enabled to the front of pairs_, and returns their number.
template <class Primitive>
std::size_t ClusterSweeper<Primitive>::dropDisabledParts(std::size_t pairs) {
  const PartPairs enabled = input_.set.parts->pairs();
  const std::uint32_t* const part = sorted_.parts.data();
  BoxPair* next = pairs_.data();
  for (std::size_t i = 0; i < pairs; ++i) {
    const BoxPair pair = pairs_[i];
    *next = pair;
    next += enabled.enabled(part[pair.a.value], part[pair.b.value]);
  }
  return static_cast<std::size_t>(next - pairs_.data());
}

// Filters the pairs found since the last call, and decides those that the filters leave.
template <class Primitive>
void ClusterSweeper<Primitive>::decideFound() {
  filtered_.clear();
  std::size_t pairs = pairsOfBoxes();  // may reallocate pairs_
  if (input_.set.parts != nullptr) pairs = dropDisabledParts(pairs);
  filter_.filter(sorted_.triangles, pairs_.data(), pairs, filtered_);
  rows_.clear();
  found_count_ = 0;
  output_.work.add(Stage::kSweep, watch_.lapMs());
  narrowPhase(input_, filtered_, output_);
  output_.work.add(Stage::kNarrowPhase, watch_.lapMs());
}

// Sorts one cluster, sweeps it, and decides the last part of what was found.
template <class Primitive>
void ClusterSweeper<Primitive>::sweep(ClusterIndex cluster) {
  const std::vector<std::uint32_t>& begin = input_.assignment.entry_begin;
  if (begin[cluster.value] == begin[cluster.value + 1]) return;
  watch_ = Stopwatch();
  rows_.clear();
  found_count_ = 0;
  const bool is_sorted = sorter_.sort(cluster, sorted_);
  output_.work.add(Stage::kSort, watch_.lapMs());
  if (!is_sorted) return;
  sweepGroups();
  if (!input_.limit.over()) decideFound();
}

template class ClusterSweeper<Triangle>;
template class ClusterSweeper<MovingTriangle>;

}  // namespace deformable_contact_monitor
