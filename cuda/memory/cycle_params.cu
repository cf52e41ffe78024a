#include <algorithm>

#include "cuda/memory/cycle_params.cuh"

namespace deformable_contact_monitor {
namespace {

// Returns CycleParams::bucket_shift: kBuckets are divided among `groups` groups, and each gets the
// greatest power of two that fits.
std::uint32_t bucketShift(std::uint32_t groups) {
  std::uint32_t shift = kAxisBits;
  for (std::uint32_t buckets = 2; buckets * std::max(groups, 1U) <= kBuckets; buckets *= 2) --shift;
  return shift;
}

// Returns how many columns a work unit has. A small scene has few units, so they must be small to
// give all warps equal work.
std::uint32_t unitColumns(std::uint32_t triangles) {
  constexpr std::uint32_t kFewTriangles = 1000000, kManyTriangles = 10000000;
  if (triangles < kFewTriangles) return kLeastUnitColumns;
  return triangles < kManyTriangles ? 2 * kLeastUnitColumns : kMostUnitColumns;
}

}  // namespace

CycleParams cycleParams(const Options& options, std::uint32_t triangles, std::uint32_t groups,
                        const BodyLengths& any, const PartUse& parts) {
  CycleParams p{};
  p.overlap = options.overlap;
  p.fuzzifier = options.fuzzifier;
  p.adjacent = options.adjacent;
  p.predicates = options.predicates;
  const bool swept = options.motion == Motion::kSwept;
  p.margins = any.margins && !swept ? 1 : 0;
  p.pads = any.pads && swept ? 1 : 0;
  // The sweep can decide pairs only if there are no margins, within which pairs that are apart may
  // be contacts too.
  p.decides = !swept && !any.margins ? 1 : 0;
  const bool few_adjacent =
      options.adjacent == AdjacentPairs::kSkip || options.predicates != Predicates::kConservative;
  constexpr std::uint32_t kMany = 300000;  // triangles; above it two kernels are faster
  p.leaves_few = p.decides != 0 && few_adjacent && triangles < kMany ? 1 : 0;
  p.first_times = options.first_times ? 1 : 0;
  p.group_count = std::min(groups, kMostGroups);
  p.groups_exact = groups <= kMostGroups && !parts.matter ? 1 : 0;
  p.parts = parts.any ? 1 : 0;
  p.bucket_shift = bucketShift(p.group_count);
  p.unit_columns = unitColumns(triangles);
  p.passes = 1;
  p.index_bits = 1;
  while ((std::uint64_t{1} << p.index_bits) <= triangles) ++p.index_bits;
  return p;
}

void reportCounters(const CycleCounters& counted, std::uint32_t clusters, Counters& told) {
  told.rejected = counted.rejected;
  told.culled = counted.culled;
  told.clustered = counted.clustered;
  told.large = counted.oversized;
  told.clusters = counted.clustered > 0 ? clusters : 0;
  told.cluster_entries = counted.cluster_entries;
  told.largest_cluster = counted.largest_cluster;
  told.interval_overlaps = counted.interval_overlaps;
  told.candidates = counted.decided + counted.examined;
  told.exact = counted.exact;
  told.undecided = counted.undecided;
}

}  // namespace deformable_contact_monitor
