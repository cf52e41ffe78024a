#include "core/cpu/cluster.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/common/parallel.h"
#include "core/cpu/fuzzy_clustering.h"

namespace deformable_contact_monitor {

namespace {

constexpr std::size_t kLength = 64;  // longer lists cost more to build than they save
static_assert(kLength <= kMostNeighbours);

// Removes prototypes that coincide with an earlier one. The others keep their order, so that a
// cluster has the same number from cycle to cycle.
std::vector<Vec3f> distinct(const std::vector<Vec3f>& prototypes, const CycleLimit& limit) {
  // Sorted by x, a prototype's duplicates are near in the order.
  std::vector<std::uint32_t> order(prototypes.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&prototypes](std::uint32_t a, std::uint32_t b) {
    return prototypes[a].x != prototypes[b].x ? prototypes[a].x < prototypes[b].x : a < b;
  });
  std::vector<bool> duplicate(prototypes.size(), false);
  PacedLimit pace(limit, 1 << 16);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Vec3f& p = prototypes[order[i]];
    for (std::size_t j = i; j-- > 0 && !pace.over();) {
      const Vec3f& q = prototypes[order[j]];
      if (!duplicate[order[j]] && squaredDistance(p, q) < kCoincident2) duplicate[order[i]] = true;
      if (duplicate[order[i]] || (p.x - q.x) * (p.x - q.x) >= kCoincident2) break;
    }
  }
  std::vector<Vec3f> kept;
  for (std::size_t g = 0; g < prototypes.size(); ++g) {
    if (!duplicate[g]) kept.push_back(prototypes[g]);
  }
  return kept;
}

}  // namespace

void Prototypes::build(const std::vector<Vec3f>& prototypes, const CycleLimit& limit) {
  points_ = distinct(prototypes, limit);
  list_reach_.resize(points_.size());
  neighbours_.assign(points_.size() * kMostNeighbours, Neighbour());
  neighbour_cluster_.resize(neighbours_.size());
  parallelBlocks(limit, points_.size(), 4, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<std::pair<float, std::uint32_t>> others;
    for (std::size_t g = begin; g < end; ++g) listNeighbours(g, others);
  });
}

// Lists the prototypes nearest to prototype g. `others` is scratch space.
void Prototypes::listNeighbours(std::size_t g,
                                std::vector<std::pair<float, std::uint32_t>>& others) {
  const auto length = static_cast<std::uint32_t>(std::min(kLength, points_.size() - 1));
  others.clear();
  for (std::uint32_t k = 0; k < points_.size(); ++k) {
    if (k != g) others.emplace_back(squaredDistance(points_[g], points_[k]), k);
  }
  const auto last = others.begin() + length;
  std::nth_element(others.begin(), last - (length > 0 ? 1 : 0), others.end());
  std::sort(others.begin(), last);
  for (std::uint32_t i = 0; i < length; ++i) {
    const auto& [d2, k] = others[i];
    neighbours_[g * kMostNeighbours + i] = {points_[k], std::sqrt(d2)};
    neighbour_cluster_[g * kMostNeighbours + i] = k;
  }
  const bool all = length + 1 == points_.size();
  list_reach_[g] = all ? INFINITY : std::sqrt(others[length - 1].first);
}

namespace {

constexpr ClusterCountPolicy kClusterCounts{1000, 2048, 2000, 8};
constexpr std::uint32_t kLeastSamples = 2048;
constexpr int kColdIterations = 2;  // a cold start takes as many times the iterations of a refresh

// Returns refreshed prototypes. `warm` has scaled prototypes to start from; if it is empty, they
// start from seeds among the points.
std::vector<Vec3f> refreshed(std::vector<Vec3f> warm, std::size_t count,
                             const std::vector<Vec3f>& points, const Options& options,
                             const CycleLimit& limit) {
  FuzzyClustering clustering(options.fuzzifier, limit);
  const bool cold = warm.empty();
  if (cold) {
    clustering.initialise(points, count);
  } else {
    clustering.setPrototypes(std::move(warm));
  }
  const int iterations = options.iterations * (cold ? kColdIterations : 1);
  for (int i = 0; i < iterations && !limit.over(); ++i) clustering.iterate(points);
  return clustering.prototypes();
}

}  // namespace

template <class Primitive>
std::vector<Vec3f> sampleCentroids(const WorkingSet& set, const SizeSplit& split,
                                   const Sampling& sampling) {
  std::vector<Vec3f> centroids(sampling.samples);
  constexpr std::size_t kBlock = 512;
  parallelBlocks(centroids.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s) {
      Vec3f scaled[kPoints<Primitive>];
      split.scaled(set.posed<Primitive>(split.regular[sampling.triangleOf(s)]), scaled);
      centroids[s] = meanOf<Primitive>(scaled);
    }
  });
  return centroids;
}

template <class Primitive>
bool PrototypeTracker::update(const WorkingSet& set, const SizeSplit& split, const Options& options,
                              const CycleLimit& limit, Prototypes& searchable) {
  const std::size_t count =
      clusterCountFor(options.clusters, kClusterCounts, split.regular.size(), prototypes_.size());
  const bool cold = prototypes_.size() != count;
  std::vector<Vec3f> scaled;
  for (const Vec3d& p : prototypes_) scaled.push_back(toFloat(split.scale.applyExact(p)));
  if (count <= 1) {
    scaled.assign(1, Vec3f());
  } else if (cold || ++cycles_since_refresh_ >= options.refresh_period) {
    cycles_since_refresh_ = 0;
    const Sampling sampling = samplingOf(static_cast<std::uint32_t>(split.regular.size()),
                                         static_cast<std::uint32_t>(count), kLeastSamples);
    if (cold) scaled.clear();
    scaled = refreshed(std::move(scaled), count, sampleCentroids<Primitive>(set, split, sampling),
                       options, limit);
  }
  searchable.build(scaled, limit);
  if (limit.wasOver()) return cold;
  prototypes_.clear();
  const SceneScale& scale = kIsMoving<Primitive> ? split.scale_after : split.scale;
  for (const Vec3f& p : scaled) prototypes_.push_back(scale.invert(p));
  return cold;
}

template std::vector<Vec3f> sampleCentroids<Triangle>(const WorkingSet&, const SizeSplit&,
                                                      const Sampling&);
template bool PrototypeTracker::update<Triangle>(const WorkingSet&, const SizeSplit&,
                                                 const Options&, const CycleLimit&, Prototypes&);
template bool PrototypeTracker::update<MovingTriangle>(const WorkingSet&, const SizeSplit&,
                                                       const Options&, const CycleLimit&,
                                                       Prototypes&);

}  // namespace deformable_contact_monitor
