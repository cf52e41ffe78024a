#include <algorithm>

#include "cuda/memory/cycle_params.cuh"

namespace deformable_contact_monitor {
namespace {

// As many buckets for each group as there are, in powers of two.
std::uint32_t bucketShift(std::uint32_t groups) {
  std::uint32_t shift = kAxisBits;
  for (std::uint32_t buckets = 2; buckets * std::max(groups, 1U) <= kBuckets; buckets *= 2) --shift;
  return shift;
}

// The fewer units a scene has, the smaller they must be to share them out evenly.
std::uint32_t unitColumns(std::uint32_t triangles) {
  constexpr std::uint32_t kFewTriangles = 1000000, kManyTriangles = 10000000;
  if (triangles < kFewTriangles) return kLeastUnitColumns;
  return triangles < kManyTriangles ? 2 * kLeastUnitColumns : kMostUnitColumns;
}

}  // namespace

CycleParams cycleParams(const Options& options, std::uint32_t triangles, std::uint32_t groups,
                        const BodyLengths& any) {
  CycleParams p{};
  p.overlap = options.overlap;
  p.fuzzifier = options.fuzzifier;
  p.adjacent = options.adjacent;
  p.predicates = options.predicates;
  const bool swept = options.motion == Motion::kSwept;
  p.margins = any.margins && !swept ? 1 : 0;
  p.pads = any.pads && swept ? 1 : 0;
  // Elsewhere pairs that are apart may be near, or less than certainty is asked for.
  p.settles = !swept && !any.margins && options.predicates != Predicates::kFast ? 1 : 0;
  const bool few_sharers =
      options.adjacent == AdjacentPairs::kSkip || options.predicates == Predicates::kExact;
  constexpr std::uint32_t kMany = 300000;  // triangles: then those left are worth two steps
  p.leaves_few = p.settles != 0 && few_sharers && triangles < kMany ? 1 : 0;
  p.first_times = options.first_times ? 1 : 0;
  p.group_count = std::min(groups, kMostGroups);
  p.groups_exact = groups <= kMostGroups ? 1 : 0;
  p.bucket_shift = bucketShift(p.group_count);
  p.unit_columns = unitColumns(triangles);
  p.passes = 1;
  p.index_bits = 1;
  while ((std::uint64_t{1} << p.index_bits) <= triangles) ++p.index_bits;
  return p;
}

void tell(const CycleCounters& counted, std::uint32_t clusters, Counters& told) {
  told.rejected = counted.rejected;
  told.culled = counted.culled;
  told.clustered = counted.clustered;
  told.large = counted.large;
  told.clusters = counted.clustered > 0 ? clusters : 0;
  told.cluster_entries = counted.members;
  told.largest_cluster = counted.largest_cluster;
  told.interval_overlaps = counted.interval_overlaps;
  told.candidates = counted.settled + counted.judged;
  told.exact = counted.exact;
  told.undecided = counted.undecided;
}

}  // namespace deformable_contact_monitor
