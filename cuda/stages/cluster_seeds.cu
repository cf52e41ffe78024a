// Stage cluster, ahead of a cycle whose clusters are new.
#include "core/rules/sampling.h"
#include "cuda/device/block_prefix.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 1024;

// The prototypes g for which seedOf(g, clusters, centroids) is `place`.
__device__ void putSeeds(const ClusterArrays& clusters, std::uint32_t centroids,
                         std::uint32_t place, const Vec3f& centroid) {
  const std::uint64_t count = clusters.count;
  const auto guess = static_cast<std::uint32_t>(place * count / centroids);
  std::uint32_t g = guess > 0 ? guess - 1 : 0;
  while (g < count && seedOf(g, count, centroids) < place) ++g;
  for (; g < count && seedOf(g, count, centroids) == place; ++g) {
    clusters.prototypes[ClusterIndex(g)] = centroid;
  }
}

// One block: prototypes from the first `count` of clusters.samples, evenly spread over those that
// there are.
__global__ void __launch_bounds__(kThreads)
    seedKernel(ClusterArrays clusters, std::uint32_t count) {
  const std::uint32_t each = (count + kThreads - 1) / kThreads;
  const std::uint32_t first = min(count, threadIdx.x * each), end = min(count, first + each);
  const auto isThere = [&](std::uint32_t s) {
    return clusters.samples[Place(s)].near.value != kNone;
  };
  std::uint32_t mine = 0, all;
  for (std::uint32_t s = first; s < end; ++s) mine += isThere(s) ? 1 : 0;
  std::uint32_t place = blockPrefix<kThreads>(mine, all);
  for (std::uint32_t s = first; s < end; ++s) {
    if (isThere(s)) putSeeds(clusters, all, place++, clusters.samples[Place(s)].centroid);
  }
}

// A thread for each cluster: no frame fits yet, no list says how far it reaches, no bin has room.
__global__ void __launch_bounds__(kThreads) startKernel(CycleArrays c) {
  const ClusterIndex g(blockIdx.x * kThreads + threadIdx.x);
  if (g.value >= c.clusters.count) return;
  ClusterFrame frame{};
  for (int k = 0; k < 3; ++k) {
    frame.axes.axis[k] = {k == 0 ? 1.0F : 0.0F, k == 1 ? 1.0F : 0.0F, k == 2 ? 1.0F : 0.0F};
    frame.along[k] = Quantiser(-1, 1);
  }
  c.sweep.frames[g] = frame;
  c.clusters.list_reach[g] = 0;
  c.members.next_bins[g] = Bin{};
}

}  // namespace

void launchClusterSeeds(const CycleArrays& cycle, std::uint32_t samples, cudaStream_t stream) {
  seedKernel<<<1, kThreads, 0, stream>>>(cycle.clusters, samples);
}

void launchClusterStart(const CycleArrays& cycle, cudaStream_t stream) {
  startKernel<<<(cycle.clusters.count + kThreads - 1) / kThreads, kThreads, 0, stream>>>(cycle);
  launchClusterLists(cycle, stream);
}

}  // namespace deformable_contact_monitor
