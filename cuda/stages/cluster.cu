// What the next cycle starts from: fuzzy c-means on this cycle's samples, the prototypes' lists of
// neighbours, the clusters' frames, and the sizes of their bins. All of it steers speed alone.
#include "core/cpu/fuzzy_clustering.h"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;

// A warp per sample. Memberships in the nearest prototype and its neighbours; in the others they
// are small, and taken as none.
__global__ void __launch_bounds__(kThreads) membershipKernel(CycleView c) {
  const std::uint32_t s = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  if (s >= c.sample_count) return;
  const Sample sample = c.samples[s];
  if (sample.near == kNone) return;
  const FuzzyPowers powers{c.params->fuzzifier};
  constexpr unsigned kEach = 2;  // of the nearest ones
  const std::size_t begin = std::size_t{sample.near} * kMostNeighbours;
  std::uint32_t cluster[kEach];
  Vec3f away[kEach];
  float d2[kEach], least2 = INFINITY;
  for (unsigned k = 0; k < kEach; ++k) {
    // The nearest stands before its neighbours.
    const unsigned place = laneId() + k * kWarp;
    Vec3f prototype = c.live_prototypes[sample.near];
    cluster[k] = sample.near;
    bool there = true;
    if (place > 0) {
      const Neighbour n = c.neighbours[begin + place - 1];
      there = !isnan(n.distance);
      prototype = n.prototype;
      cluster[k] = c.neighbour_cluster[begin + place - 1];
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
    float* sums = reinterpret_cast<float*>(&c.membership_sums[cluster[k]]);
    atomicAdd(sums, um * away[k].x);
    atomicAdd(sums + 1, um * away[k].y);
    atomicAdd(sums + 2, um * away[k].z);
    atomicAdd(sums + 3, um);
  }
}

__global__ void __launch_bounds__(kThreads) moveKernel(CycleView c) {
  const std::uint32_t g = blockIdx.x * kThreads + threadIdx.x;
  if (g >= c.cluster_count) return;
  const float4 sum = c.membership_sums[g];
  c.membership_sums[g] = make_float4(0, 0, 0, 0);
  if (!(sum.w > 0)) return;
  const Vec3f moved = c.prototypes[g] + Vec3f{sum.x, sum.y, sum.z} * (1 / sum.w);
  if (isFinite(moved)) c.prototypes[g] = moved;
}

// A warp per prototype. One that coincides with an earlier one would only share its triangles: it
// is put where it is nobody's.
__global__ void __launch_bounds__(kThreads) retireKernel(CycleView c) {
  const std::uint32_t g = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  if (g >= c.cluster_count) return;
  const Vec3f p = c.prototypes[g];
  bool coincides = false;
  for (std::uint32_t first = 0; first < g && !coincides; first += kWarp) {
    const std::uint32_t j = first + laneId();
    coincides = __any_sync(kFullWarp, j < g && squaredDistance(p, c.prototypes[j]) < kCoincident2);
  }
  constexpr float kFar = 1e18F;  // its square is finite
  if (laneId() == 0) c.live_prototypes[g] = coincides ? Vec3f{kFar, kFar, kFar} : p;
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

// A block per prototype: finds a squared distance within which there are many others, but not more
// than a list holds, by bisection of its bits; starting from last cycle's.
__global__ void __launch_bounds__(kThreads) neighbourKernel(CycleView c) {
  const std::uint32_t g = blockIdx.x, count = c.cluster_count;
  const Vec3f p = c.live_prototypes[g];
  const auto bitsTo = [&](std::uint32_t j) {
    return __float_as_uint(squaredDistance(p, c.live_prototypes[j]));
  };
  constexpr std::uint32_t kEnough = 3 * kMostNeighbours / 4, kInfinityBits = 0x7f800000U;
  const bool all = count - 1 <= kMostNeighbours;
  std::uint32_t bound = kInfinityBits;
  if (!all) {
    std::uint32_t low = 0, high = kInfinityBits;  // too few within low; too many within high
    std::uint32_t step = 1U << 20;  // an eighth of an octave; nearby first, for little has changed
    const float reach = c.list_reach[g];
    bound = __float_as_uint(reach * reach);  // infinite or zero: from nowhere
    if (!(bound > low && bound < high)) bound = __float_as_uint(1e-2F);
    while (true) {
      std::uint32_t within = 0;
      for (std::uint32_t j = threadIdx.x; j < count; j += kThreads) {
        within += j != g && bitsTo(j) < bound ? 1 : 0;
      }
      within = blockSum(within);
      if (within >= kEnough && within <= kMostNeighbours) break;
      const bool too_many = within > kMostNeighbours;
      (too_many ? high : low) = bound;
      if (high - low <= 1) {
        bound = low;
        break;
      }
      if (high - low <= step) step = (high - low) / 2;
      bound = too_many ? high - step : low + step;
      step *= 2;
    }
  }

  __shared__ std::uint64_t found[kMostNeighbours];
  __shared__ std::uint32_t length;
  if (threadIdx.x == 0) length = 0;
  __syncthreads();
  for (std::uint32_t j = threadIdx.x; j < count; j += kThreads) {
    const std::uint32_t bits = bitsTo(j);
    if (j == g || bits >= bound) continue;
    found[atomicAdd(&length, 1U)] = std::uint64_t{bits} << 32 | j;
  }
  __syncthreads();
  const std::size_t begin = std::size_t{g} * kMostNeighbours;
  for (std::uint32_t i = threadIdx.x; i < length; i += kThreads) {
    std::uint32_t rank = 0;
    for (std::uint32_t k = 0; k < length; ++k) rank += found[k] < found[i] ? 1 : 0;
    const auto j = static_cast<std::uint32_t>(found[i]);
    const float d2 = __uint_as_float(static_cast<std::uint32_t>(found[i] >> 32));
    c.neighbours[begin + rank] = {c.live_prototypes[j], sqrtf(d2)};
    c.neighbour_cluster[begin + rank] = j;
  }
  for (std::uint32_t i = length + threadIdx.x; i < kMostNeighbours; i += kThreads) {
    c.neighbours[begin + i] = Neighbour();
  }
  if (threadIdx.x == 0) c.list_reach[g] = all ? INFINITY : sqrtf(__uint_as_float(bound));
}

__device__ std::uint32_t wantedCapacity(const CycleView& c, std::uint32_t bin) {
  const bool large = bin == c.cluster_count;
  const std::uint32_t count = large ? c.counters->large : countOf(c, bin);
  constexpr std::uint32_t kSpare = 32;
  // Remembers peaks for a while, so that a scene that swings to and fro fits.
  const std::uint32_t before = c.bins[bin].capacity;
  return max(count + count / 4 + kSpare, before - before / 32);
}

// One block: an exclusive sum of the bins' capacities.
constexpr unsigned kScanThreads = 1024;
__global__ void __launch_bounds__(kScanThreads) sizeBinsKernel(CycleView c) {
  __shared__ std::uint32_t warp_total[kScanThreads / kWarp];
  __shared__ std::uint32_t entries, largest;
  if (threadIdx.x == 0) entries = largest = 0;
  const std::uint32_t bins = c.cluster_count + 1;
  std::uint32_t begin = 0;
  for (std::uint32_t first = 0; first < bins; first += kScanThreads) {
    const std::uint32_t g = first + threadIdx.x;
    const std::uint32_t capacity = g < bins ? wantedCapacity(c, g) : 0;
    std::uint32_t total, before = warpPrefix(capacity, total);
    __syncthreads();
    if (laneId() == 0) warp_total[threadIdx.x / kWarp] = total;
    const std::uint32_t count = g < c.cluster_count ? countOf(c, g) : 0;
    atomicAdd(&entries, count);
    atomicMax(&largest, count);
    __syncthreads();
    std::uint32_t sum = 0;
    for (unsigned w = 0; w < kScanThreads / kWarp; ++w) {
      before += w < threadIdx.x / kWarp ? warp_total[w] : 0;
      sum += warp_total[w];
    }
    // Bins that do not fit are cut; the host makes room.
    const std::uint32_t place = min(begin + before, c.member_capacity);
    if (g < bins) c.next_bins[g] = {place, min(capacity, c.member_capacity - place)};
    begin += sum;
  }
  __syncthreads();
  if (threadIdx.x == 0) {
    c.counters->bins_wanted = begin;
    c.counters->entries = entries;
    c.counters->largest_cluster = largest;
  }
}

__device__ Quantiser around(double mean, double variance) {
  const double reach = 2.5 * sqrt(variance > 0 ? variance : 0);
  return {static_cast<float>(mean - reach), static_cast<float>(mean + reach)};
}

__global__ void __launch_bounds__(kWarp) frameKernel(CycleView c) {
  const std::uint32_t g = blockIdx.x * kWarp + threadIdx.x;
  if (g >= c.cluster_count) return;
  const Moments m = c.moments[g];
  if (!(m.count > 0)) return;
  const PrincipalAxes axes = principalAxes(m);
  const Vec3f about = c.frames[g].centre;
  const double origin[3] = {about.x, about.y, about.z};
  double mean[3], covariance[3][3];
  constexpr int kIndex[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  for (int i = 0; i < 3; ++i) mean[i] = m.sum[i] / m.count;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      covariance[i][j] = m.product[kIndex[i][j]] / m.count - mean[i] * mean[j];
    }
  }
  ClusterFrame frame;
  frame.axes = axes;
  frame.centre = about + Vec3f{static_cast<float>(mean[0]), static_cast<float>(mean[1]),
                               static_cast<float>(mean[2])};
  for (int k = 0; k < 3; ++k) {
    const double a[3] = {axes.axis[k].x, axes.axis[k].y, axes.axis[k].z};
    double centre = 0, variance = 0;
    for (int i = 0; i < 3; ++i) {
      centre += a[i] * (mean[i] + origin[i]);
      for (int j = 0; j < 3; ++j) variance += a[i] * a[j] * covariance[i][j];
    }
    frame.along[k] = around(centre, variance);
    frame.world[k] = around(mean[k] + origin[k], covariance[k][k]);
  }
  frame.world[3] = frame.world[2];
  c.frames[g] = frame;
}

}  // namespace

void launchMovePrototypes(const CycleView& cycle, cudaStream_t stream) {
  membershipKernel<<<(cycle.sample_count + kWarps - 1) / kWarps, kThreads, 0, stream>>>(cycle);
  moveKernel<<<(cycle.cluster_count + kThreads - 1) / kThreads, kThreads, 0, stream>>>(cycle);
}

void launchListNeighbours(const CycleView& cycle, cudaStream_t stream) {
  retireKernel<<<(cycle.cluster_count + kWarps - 1) / kWarps, kThreads, 0, stream>>>(cycle);
  neighbourKernel<<<cycle.cluster_count, kThreads, 0, stream>>>(cycle);
}

void launchSizeBins(const CycleView& cycle, cudaStream_t stream) {
  sizeBinsKernel<<<1, kScanThreads, 0, stream>>>(cycle);
}

void launchFrames(const CycleView& cycle, cudaStream_t stream) {
  frameKernel<<<(cycle.cluster_count + kWarp - 1) / kWarp, kWarp, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
