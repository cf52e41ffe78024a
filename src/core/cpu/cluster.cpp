#include "core/cpu/cluster.h"

#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/common/parallel.h"
#include "core/cpu/fuzzy_clustering.h"
#include "core/rules/cluster_count.h"

namespace deformable_contact_monitor {
namespace {

constexpr ClusterCountPolicy kClusterCounts{1000, 2048, 600, 8};
constexpr std::uint32_t kLeastSamples = 2048;
constexpr int kColdIterations = 5;  // times as many as a warm refresh

// `warm`: scaled prototypes to start from; empty: from seeds among the points.
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

template <class Hull>
std::vector<Vec3f> sampleCentroids(const WorkingSet& set, const SizeSplit& split,
                                   const Sampling& sampling) {
  std::vector<Vec3f> centroids(sampling.samples);
  constexpr std::size_t kBlock = 512;
  parallelBlocks(centroids.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s) {
      Vec3f scaled[kPoints<Hull>];
      split.scaled(set.posed<Hull>(split.regular[sampling.triangleOf(s)]), scaled);
      centroids[s] = meanOf<Hull>(scaled);
    }
  });
  return centroids;
}

template <class Hull>
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
    scaled = refreshed(std::move(scaled), count, sampleCentroids<Hull>(set, split, sampling),
                       options, limit);
  }
  searchable.build(scaled, limit);
  if (limit.wasOver()) return cold;
  prototypes_.clear();
  const SceneScale& scale = kIsMoving<Hull> ? split.scale_after : split.scale;
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
