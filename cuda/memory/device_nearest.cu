#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "core/common/contact_geometry.h"
#include "core/common/part_table.h"
#include "core/rules/margins.h"
#include "cuda/device/cuda_error.h"
#include "cuda/device/warp.cuh"
#include "cuda/memory/device_nearest.cuh"
#include "cuda/memory/pinned_pages.cuh"

namespace deformable_contact_monitor {
namespace {

// How many pairs of tiles are listed; if there are more, they are searched at once.
constexpr std::uint32_t kNearTiles = 1 << 16;
// How many pairs of triangles that were the best so far are noted at least, and for each pair of
// bodies or parts; if there are more, the last kernel searches again.
constexpr std::uint32_t kHits = 1 << 12, kHitsOfPair = 4;
// Warps add their number to a task's number to get their next task, which must not wrap.
constexpr std::uint32_t kMostTasks = ~std::uint32_t{0} / 2;

template <class T>
bool areSame(const std::vector<T>& a, const std::vector<T>& b) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): a needless copy does no harm
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

// The regions of all bodies, in the order of bodies and tiles.
struct Regions {
  std::vector<TileRegion> all;
  std::vector<std::uint32_t> first;  // of each body; one more element has the end

  explicit Regions(const SceneTables& tables) {
    for (const DeviceBody& body : tables.bodies) {
      first.push_back(static_cast<std::uint32_t>(all.size()));
      const std::uint32_t tiles = (body.triangle_count + kWarp - 1) / kWarp;
      for (std::uint32_t t = 0; t < tiles; t += kWarp) {
        all.push_back({TileIndex(body.first_tile + t), std::min(kWarp, tiles - t)});
      }
    }
    first.push_back(static_cast<std::uint32_t>(all.size()));
  }
  std::uint32_t countOf(std::uint32_t body) const { return first[body + 1] - first[body]; }
};

// Returns which parts of two bodies are searched: all together, and, if there are `numbers` and one
// of the bodies has named parts, each enabled pair. kNone: all parts.
std::vector<std::pair<std::uint32_t, std::uint32_t>> partsOf(
    const Scene& scene, const std::optional<PartTable>& numbers, BodyId a, BodyId b) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> parts = {{kNone, kNone}};
  if (!numbers || (scene.body(a).parts.empty() && scene.body(b).parts.empty())) return parts;
  for (const PartId part_a : scene.body(a).listed_parts) {
    for (const PartId part_b : scene.body(b).listed_parts) {
      if (!scene.partPairEnabled(a, part_a, b, part_b)) continue;
      parts.emplace_back(numbers->numberOf(a, part_a), numbers->numberOf(b, part_b));
    }
  }
  return parts;
}

// Copies a list to page-locked memory.
template <class T>
void stage(const std::vector<T>& from, PinnedBuffer<T>& to) {
  to.grow(from.size());
  std::copy(from.begin(), from.end(), to.data());
}

}  // namespace

void DeviceNearest::layOut(const Scene& scene, const SceneTables& tables, bool searches,
                           bool by_part) {
  arrays_.pair_count = 0;
  if (!searches) return;
  Regions regions(tables);
  std::vector<NearestBodies> pairs;
  std::optional<PartTable> numbers;
  if (by_part) numbers.emplace(scene);
  std::uint64_t tasks = 0;
  const auto count = static_cast<std::uint32_t>(tables.bodies.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    for (std::uint32_t j = i + 1; j < count; ++j) {
      const BodyId a = tables.taking_part[i], b = tables.taking_part[j];
      const std::uint64_t its = std::uint64_t{regions.countOf(i)} * regions.countOf(j);
      if (its == 0 || !scene.pairEnabled(a, b)) continue;
      const bool on_device = scene.body(a).device_vertices || scene.body(b).device_vertices;
      const float margin_m = pairMargin(scene.body(a).margin_m, scene.body(b).margin_m);
      for (const auto& [part_a, part_b] : partsOf(scene, numbers, a, b)) {
        pairs.push_back({BodyIndex(i), BodyIndex(j), margin_m, regions.first[i], regions.first[j],
                         regions.countOf(j), static_cast<std::uint32_t>(tasks), on_device ? 1U : 0U,
                         part_a, part_b});
        tasks += its;
      }
    }
  }
  if (tasks > kMostTasks) {
    throw CudaError(BackendFault::kSceneTooLarge,
                    "the bodies are too large to search their nearest triangles on CUDA");
  }
  sent_ = sent_ && areSame(pairs, pairs_) && areSame(regions.all, regions_);
  pairs_ = std::move(pairs);
  regions_ = std::move(regions.all);
  arrays_.pair_count = static_cast<std::uint32_t>(pairs_.size());
  arrays_.region_count = static_cast<std::uint32_t>(regions_.size());
  arrays_.task_count = static_cast<std::uint32_t>(tasks);
  if (pairs_.empty()) return;
  CycleSizes::raise(sizes_.nearest_pairs, pairs_.size());
  CycleSizes::raise(sizes_.regions, regions_.size());
  CycleSizes::raise(sizes_.nearest_tiles, tables.tile_count);
  if (tables.part_use.any) CycleSizes::raise(sizes_.part_tiles, tables.tile_count);
  sizes_.near_tiles = kNearTiles;
  CycleSizes::raise(sizes_.nearest_hits, std::max<std::size_t>(kHits, kHitsOfPair * pairs_.size()));
  found_.grow(sizes_.nearest_pairs);
  arrays_.found.pointTo(found_.data());
}

void DeviceNearest::send(HostCopies& copies) {
  if (sent_ || arrays_.pair_count == 0) return;
  stage(pairs_, staged_pairs_);
  stage(regions_, staged_regions_);
  copies.add(static_cast<const NearestBodies*>(reachedAt(staged_pairs_.data())), pairs_.size(),
             arrays_.pairs.data());
  copies.add(static_cast<const TileRegion*>(reachedAt(staged_regions_.data())), regions_.size(),
             arrays_.regions.data());
  sent_ = true;
}

bool DeviceNearest::addTo(const Scene& scene, const SceneTables& tables,
                          DetectionResult& result) const {
  for (std::size_t i = 0; i < arrays_.pair_count; ++i) {
    const NearestFound& found = found_[i];
    if (found.state == NearestFound::kCutOff) return false;
    if (found.state != NearestFound::kFound) continue;
    const TrianglePair pair{tables.taking_part[pairs_[i].a.value], found.triangle_a,
                            tables.taking_part[pairs_[i].b.value], found.triangle_b};
    // The host computes the points of a few pairs sooner than the device.
    const NearestPair nearest =
        pairs_[i].points_on_device != 0
            ? NearestPair{pair, found.distance_m, found.point_a, found.point_b, found.normal}
            : nearestPairOf(scene, pair, found.distance_m);
    if (pairs_[i].part_a == kNone) {
      result.nearest.push_back(nearest);
    } else {
      const auto& of_a = tables.parts[pairs_[i].part_a];
      const auto& of_b = tables.parts[pairs_[i].part_b];
      result.nearest_parts.push_back({{of_a.first, of_b.first, of_a.second, of_b.second}, nearest});
    }
  }
  std::sort(result.nearest_parts.begin(), result.nearest_parts.end(),
            [](const NearestOfParts& x, const NearestOfParts& y) { return x.parts < y.parts; });
  return true;
}

}  // namespace deformable_contact_monitor
