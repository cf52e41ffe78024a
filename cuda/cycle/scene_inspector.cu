// Chooses between a warm and a cold start. A warm start keeps the clusters of the last cycle. Any
// clusters give correct results; unsuitable ones only make a cycle slow.
#include <algorithm>
#include <cmath>

#include "cuda/cycle/scene_inspector.cuh"
#include "cuda/device/boxes.cuh"

namespace deformable_contact_monitor {
namespace {

// If more than one in so many triangles is new, the scene may be a different one.
constexpr std::uint64_t kNewFraction = 16;

}  // namespace

bool SceneInspector::isColdFor(const Options& options) const {
  return cold_ || asked_clusters_ != options.clusters || motion_ != options.motion;
}

void SceneInspector::beginCycle(const Options& options) {
  cold_ = true;
  motion_ = options.motion;
}

bool SceneInspector::needsInspection(const DeviceScene::Change& change, std::uint32_t triangles) {
  changed_triangles_ += change.more_triangles + change.fewer_triangles + change.replaced_triangles;
  return kNewFraction * changed_triangles_ > triangles;
}

ColdStart SceneInspector::inspect(const Scene& scene, const ScenePartition& partition,
                                  const Options& options, const CycleLimit& limit,
                                  Inspection inspection) {
  return measurer_.measure(scene, partition, options, policy_, inspection, limit);
}

bool SceneInspector::adapt(const Inspected& inspected, const Options& options,
                           const CycleLimit& limit, std::uint64_t memory_limit_bytes,
                           bool& started_cold, ColdStart& start, CycleSizes& sizes) {
  const auto inspectAs = [&](Inspection inspection) {
    return inspect(inspected.scene, inspected.partition, options, limit, inspection);
  };
  if (!started_cold) {
    if (start.seeds.empty()) start = inspectAs(Inspection::kBrief);
    started_cold = !isAlike(start, inspected, options, sizes.clusters);
  }
  if (started_cold) {
    start = inspectAs(sample_unrepresentative_ ? Inspection::kAll : Inspection::kSample);
  }
  if (limit.wasOver()) return false;
  changed_triangles_ = 0;
  size_rule_ = start.size_rule;
  oversized_at_start_ = static_cast<std::uint32_t>(start.oversized);
  const std::size_t clusters = started_cold ? start.seeds.size() : sizes.clusters;
  sizes.prepare(static_cast<std::uint32_t>(start.regular), static_cast<std::uint32_t>(clusters),
                memory_limit_bytes);
  return true;
}

// Returns whether the clusters of the last scene suit this one. They do if hardly any triangle is
// new, the scene has neither moved far nor changed its size by more than a factor of two, and it
// needs the same number of clusters.
bool SceneInspector::isAlike(const ColdStart& start, const Inspected& inspected,
                             const Options& options, std::uint32_t clusters) const {
  if (kNewFraction * inspected.change.more_triangles > inspected.triangles) return false;
  const double ratio = start.scale.scale / scale_.scale;
  const Vec3d moved = scale_.applyExact(start.scale.origin);  // in units of half the scene's size
  const double most_moved = std::max({std::fabs(moved.x), std::fabs(moved.y), std::fabs(moved.z)});
  const std::size_t wanted = clusterCountFor(options.clusters, policy_, start.regular, clusters);
  return ratio >= 0.5 && ratio <= 2 && most_moved < 0.25 &&
         std::max<std::size_t>(1, wanted) == clusters;
}

void SceneInspector::setSeeds(const ColdStart& start, const Options& options) {
  asked_clusters_ = options.clusters;
  scale_ = frame_ = start.scale;
  covered_ = Aabb();
}

void SceneInspector::endCycle(const CycleCounters& counted, const Options& options,
                              std::uint32_t clusters, std::uint32_t samples,
                              std::uint32_t triangles, bool started_cold) {
  constexpr std::uint64_t kSamplesEach = 4;
  const std::size_t wanted =
      clusterCountFor(options.clusters, policy_, counted.clustered, clusters);
  wanted_clusters_ = options.clusters > 0
                         ? clusters
                         : std::max<std::uint32_t>(1, static_cast<std::uint32_t>(wanted));
  // Samples are taken of all triangles, but only those of clustered triangles can become seeds.
  const bool few_samples =
      std::uint64_t{samples} * counted.clustered < kSamplesEach * wanted_clusters_ * triangles;
  const bool more_oversized =
      counted.oversized > 2 * oversized_at_start_ + 64 + counted.clustered / 64;
  cold_ = more_oversized || (wanted_clusters_ != clusters && few_samples);
  sample_unrepresentative_ = cold_ && started_cold;
  moveFrame(boxOf(counted.tiles_box));
}

// The frame covers the sampled tiles of this cycle, and those of the cycles before as long as they
// have not been left behind for some time. It is two and a half times as wide, so that they may
// move.
void SceneInspector::moveFrame(const Aabb& tiles) {
  if (tiles.empty()) return;
  if (covered_.empty()) covered_ = tiles;
  const auto followed = [](const Vec3f& from, const Vec3f& to) {
    constexpr double kOfWay = 1.0 / 8;
    return toFloat(toDouble(from) + (toDouble(to) - toDouble(from)) * kOfWay);
  };
  covered_ = {followed(covered_.min, tiles.min), followed(covered_.max, tiles.max)};
  covered_.include(tiles);
  const Vec3d low = toDouble(covered_.min), high = toDouble(covered_.max), size = high - low;
  frame_.origin = (low + high) * 0.5;
  frame_.scale = 1 / (1.25 * std::max({size.x, size.y, size.z}));
}

}  // namespace deformable_contact_monitor
