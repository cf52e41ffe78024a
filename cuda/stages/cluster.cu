// Stage cluster, for the next cycle: makes steps of fuzzy c-means with this cycle's samples, and
// builds the prototypes' lists of neighbours. It also makes new prototypes from samples, before a
// cycle whose clusters are new. All of this affects speed only, never results.
#include "core/rules/clustering.h"
#include "cuda/device/check.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;

// One warp for each of clusters.samples: computes the sample's memberships and adds them to
// clusters.membership_sums. It considers only the nearest prototype and that prototype's 63 nearest
// neighbours, because other memberships are negligible. Each lane takes kEach prototypes.
__global__ void __launch_bounds__(kThreads) membershipKernel(CycleArrays c) {
  const std::uint32_t s = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  if (s >= c.clusters.sample_count) return;
  const Sample sample = c.clusters.samples[Place(s)];
  if (sample.near.value == kNone) return;
  const FuzzyPowers powers{c.params().fuzzifier};
  constexpr unsigned kEach = 2;  // of the prototypes
  ClusterIndex cluster[kEach];
  Vec3f away[kEach];
  float d2[kEach], least2 = INFINITY;
  for (unsigned k = 0; k < kEach; ++k) {
    const unsigned place = laneId() + k * kWarp;
    Vec3f prototype = c.clusters.live_prototypes[sample.near];
    cluster[k] = sample.near;
    bool there = true;
    if (place > 0) {
      const Neighbour n = c.clusters.neighbours.row(sample.near)[place - 1];
      there = !isnan(n.distance);
      prototype = n.prototype;
      cluster[k] = ClusterIndex(c.clusters.neighbour_cluster.row(sample.near)[place - 1]);
    }
    away[k] = sample.centroid - prototype;
    d2[k] = there ? dot(away[k], away[k]) : INFINITY;
    least2 = fminf(least2, d2[k]);
  }
  for (unsigned o = kWarp / 2; o > 0; o /= 2) {
    least2 = fminf(least2, __shfl_xor_sync(kFullWarp, least2, o));
  }
  float weight[kEach], sum = 0;
  for (unsigned k = 0; k < kEach; ++k) {
    weight[k] = least2 > 0 ? (d2[k] < INFINITY ? powers.weight(least2 / d2[k]) : 0.0F)
                           : (d2[k] == 0 ? 1.0F : 0.0F);
    sum += weight[k];
  }
  sum = warpSum(sum);
  for (unsigned k = 0; k < kEach; ++k) {
    const float um = powers.power(weight[k] / sum);
    constexpr float kNegligible = 4e-4F;
    if (!(um > kNegligible)) continue;
    float* sums = reinterpret_cast<float*>(&c.clusters.membership_sums[cluster[k]]);
    atomicAdd(sums, um * away[k].x);
    atomicAdd(sums + 1, um * away[k].y);
    atomicAdd(sums + 2, um * away[k].z);
    atomicAdd(sums + 3, um);
  }
}

// One thread for each of clusters.prototypes: moves it by clusters.membership_sums.
__global__ void __launch_bounds__(kThreads) moveKernel(CycleArrays c) {
  const ClusterIndex g(blockIdx.x * kThreads + threadIdx.x);
  if (g.value >= c.clusters.count) return;
  const float4 sum = c.clusters.membership_sums[g];
  if (!(sum.w > 0)) return;
  const Vec3f moved = c.clusters.prototypes[g] + Vec3f{sum.x, sum.y, sum.z} * (1 / sum.w);
  if (isFinite(moved)) c.clusters.prototypes[g] = moved;
}

// One warp for each of clusters.prototypes: writes clusters.live_prototypes. A prototype that
// coincides with an earlier one would get the same triangles again, so it is moved so far away that
// no triangle is near it.
__global__ void __launch_bounds__(kThreads) retireKernel(CycleArrays c) {
  const ClusterIndex g((blockIdx.x * kThreads + threadIdx.x) / kWarp);
  if (g.value >= c.clusters.count) return;
  const Vec3f p = c.clusters.prototypes[g];
  bool coincides = false;
  for (std::uint32_t first = 0; first < g.value && !coincides; first += kWarp) {
    const ClusterIndex j(first + laneId());
    coincides =
        __any_sync(kFullWarp, j < g && squaredDistance(p, c.clusters.prototypes[j]) < kCoincident2);
  }
  constexpr float kFar = 1e18F;  // its square is finite
  if (laneId() == 0) c.clusters.live_prototypes[g] = coincides ? Vec3f{kFar, kFar, kFar} : p;
}

__device__ std::uint32_t blockSum(std::uint32_t x) {
  __shared__ std::uint32_t part[kWarps];
  x = warpSum(x);
  __syncthreads();
  if (laneId() == 0) part[threadIdx.x / kWarp] = x;
  __syncthreads();
  std::uint32_t sum = 0;
  for (const std::uint32_t p : part) sum += p;
  return sum;
}

// Computes squared distances of one prototype from the others, as bits. Bits of non-negative floats
// have the same order as the floats.
struct DistanceBits {
  const ClusterArrays& clusters;
  ClusterIndex from;
  Vec3f p;

  __device__ std::uint32_t operator()(std::uint32_t j) const {
    return __float_as_uint(squaredDistance(p, clusters.live_prototypes[ClusterIndex(j)]));
  }
};

// Returns the bits of a squared distance within which there are many other prototypes, but not more
// than a list holds. It starts at the last cycle's distance, because little changes from cycle to
// cycle, and bisects. Called by a whole block.
__device__ std::uint32_t listBound(const DistanceBits& bits) {
  constexpr std::uint32_t kEnough = 3 * kMostNeighbours / 4, kInfinityBits = 0x7f800000U;
  std::uint32_t low = 0, high = kInfinityBits;  // too few within `low`, too many within `high`
  std::uint32_t step = 1U << 20;  // an eighth of an octave; it doubles until both bounds are known
  const float reach = bits.clusters.list_reach[bits.from];
  std::uint32_t bound = __float_as_uint(reach * reach);  // zero or infinite if not known
  if (!(bound > low && bound < high)) bound = __float_as_uint(1e-2F);
  while (true) {
    std::uint32_t within = 0;
    for (std::uint32_t j = threadIdx.x; j < bits.clusters.count; j += kThreads) {
      within += j != bits.from.value && bits(j) < bound ? 1 : 0;
    }
    within = blockSum(within);
    if (within >= kEnough && within <= kMostNeighbours) return bound;
    const bool too_many = within > kMostNeighbours;
    (too_many ? high : low) = bound;
    if (high - low <= 1) return low;
    if (high - low <= step) step = (high - low) / 2;
    bound = too_many ? high - step : low + step;
    step *= 2;
  }
}

// One block for each of clusters.live_prototypes: writes its clusters.neighbours, neighbour_cluster
// and list_reach. It collects the neighbours in any order; then each thread finds the rank of its
// neighbour by counting those that are nearer.
__global__ void __launch_bounds__(kThreads) neighbourKernel(CycleArrays c) {
  const ClusterIndex g(blockIdx.x);
  const DistanceBits bits{c.clusters, g, c.clusters.live_prototypes[g]};
  const bool all = c.clusters.count - 1 <= kMostNeighbours;
  const std::uint32_t bound = all ? 0x7f800000U : listBound(bits);

  __shared__ std::uint64_t found[kMostNeighbours];
  __shared__ std::uint32_t length;
  if (threadIdx.x == 0) length = 0;
  __syncthreads();
  for (std::uint32_t j = threadIdx.x; j < c.clusters.count; j += kThreads) {
    const std::uint32_t d2 = bits(j);
    if (j == g.value || d2 >= bound) continue;
    found[atomicAdd(&length, 1U)] = std::uint64_t{d2} << 32 | j;
  }
  __syncthreads();
  Neighbour* const neighbours = c.clusters.neighbours.row(g);
  for (std::uint32_t i = threadIdx.x; i < length; i += kThreads) {
    std::uint32_t rank = 0;
    for (std::uint32_t k = 0; k < length; ++k) rank += found[k] < found[i] ? 1 : 0;
    const ClusterIndex j(static_cast<std::uint32_t>(found[i]));
    const float d2 = __uint_as_float(static_cast<std::uint32_t>(found[i] >> 32));
    neighbours[rank] = {c.clusters.live_prototypes[j], sqrtf(d2)};
    c.clusters.neighbour_cluster.row(g)[rank] = j.value;
  }
  for (std::uint32_t i = length + threadIdx.x; i < kMostNeighbours; i += kThreads) {
    neighbours[i] = Neighbour();
  }
  if (threadIdx.x == 0) {
    c.clusters.list_reach[g] = all ? INFINITY : sqrtf(__uint_as_float(bound));
  }
}

void movePrototypes(const CycleArrays& cycle, cudaStream_t stream) {
  const ClusterArrays& clusters = cycle.clusters;
  checkCuda(
      cudaMemsetAsync(clusters.membership_sums.data(), 0, clusters.count * sizeof(float4), stream),
      "cudaMemsetAsync");
  membershipKernel<<<(clusters.sample_count + kWarps - 1) / kWarps, kThreads, 0, stream>>>(cycle);
  moveKernel<<<(clusters.count + kThreads - 1) / kThreads, kThreads, 0, stream>>>(cycle);
}

}  // namespace

void launchCluster(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (cycle.usesBruteForce()) return;
  for (int i = 0; i < shape.refinements; ++i) {
    movePrototypes(cycle, stream);
    launchClusterLists(cycle, stream);
  }
}

void launchClusterLists(const CycleArrays& cycle, cudaStream_t stream) {
  const std::uint32_t count = cycle.clusters.count;
  retireKernel<<<(count + kWarps - 1) / kWarps, kThreads, 0, stream>>>(cycle);
  neighbourKernel<<<count, kThreads, 0, stream>>>(cycle);
}

namespace {

constexpr unsigned kSeedThreads = 1024;

// Sets the prototypes g for which seedOf(g, clusters, centroids) is `place` to `centroid`.
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

// Makes the prototypes from the first `count` of clusters.samples, in one block. They are evenly
// spread over the samples that are not empty.
__global__ void __launch_bounds__(kSeedThreads)
    seedKernel(ClusterArrays clusters, std::uint32_t count) {
  const std::uint32_t each = (count + kSeedThreads - 1) / kSeedThreads;
  const std::uint32_t first = min(count, threadIdx.x * each), end = min(count, first + each);
  const auto isThere = [&](std::uint32_t s) {
    return clusters.samples[Place(s)].near.value != kNone;
  };
  std::uint32_t mine = 0, all;
  for (std::uint32_t s = first; s < end; ++s) mine += isThere(s) ? 1 : 0;
  std::uint32_t place = blockPrefix<kSeedThreads>(mine, all);
  for (std::uint32_t s = first; s < end; ++s) {
    if (isThere(s)) putSeeds(clusters, all, place++, clusters.samples[Place(s)].centroid);
  }
}

// One thread for each new cluster: sets a default frame, a list of neighbours without reach, and an
// empty bin.
__global__ void __launch_bounds__(kSeedThreads) startKernel(CycleArrays c) {
  const ClusterIndex g(blockIdx.x * kSeedThreads + threadIdx.x);
  if (g.value >= c.clusters.count) return;
  ClusterFrame frame{};
  for (int k = 0; k < 3; ++k) {
    frame.axes.axis[k] = {k == 0 ? 1.0F : 0.0F, k == 1 ? 1.0F : 0.0F, k == 2 ? 1.0F : 0.0F};
    frame.along[k] = Quantiser(-1, 1);
  }
  c.sweep.frames[g] = frame;
  c.clusters.list_reach[g] = 0;
  c.tiles.next_bins[g] = Bin{};
}

}  // namespace

void launchClusterSeeds(const CycleArrays& cycle, std::uint32_t samples, cudaStream_t stream) {
  seedKernel<<<1, kSeedThreads, 0, stream>>>(cycle.clusters, samples);
}

void launchClusterStart(const CycleArrays& cycle, cudaStream_t stream) {
  startKernel<<<(cycle.clusters.count + kSeedThreads - 1) / kSeedThreads, kSeedThreads, 0,
                stream>>>(cycle);
  launchClusterLists(cycle, stream);
}

}  // namespace deformable_contact_monitor
