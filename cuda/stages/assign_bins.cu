// Stage assign, for the next cycle: how much room the tiles of each cluster are to have.
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

__device__ std::uint32_t wantedCapacity(const CycleArrays& c, ClusterIndex bin) {
  const std::uint32_t count = c.members.count(bin);
  constexpr std::uint32_t kSpare = 32;
  // Remembers peaks for a while, so that a scene that swings to and fro fits.
  const std::uint32_t before = c.members.bins[bin].capacity;
  return max(count + count / 4 + kSpare, before - before / 32);
}

// One block, which goes through the clusters: reads members.counts, and writes
// members.next_bins by an exclusive sum of the capacities.
constexpr unsigned kScanThreads = 1024;
__global__ void __launch_bounds__(kScanThreads) binsKernel(CycleArrays c) {
  __shared__ std::uint32_t warp_total[kScanThreads / kWarp];
  const std::uint32_t bins = c.clusters.count, room = c.members.entries.size();
  std::uint32_t begin = 0;
  for (std::uint32_t first = 0; first < bins; first += kScanThreads) {
    const ClusterIndex g(first + threadIdx.x);
    const std::uint32_t capacity = g.value < bins ? wantedCapacity(c, g) : 0;
    std::uint32_t total, before = warpPrefix(capacity, total);
    __syncthreads();
    if (laneId() == 0) warp_total[threadIdx.x / kWarp] = total;
    __syncthreads();
    std::uint32_t sum = 0;
    for (unsigned w = 0; w < kScanThreads / kWarp; ++w) {
      before += w < threadIdx.x / kWarp ? warp_total[w] : 0;
      sum += warp_total[w];
    }
    // Bins that do not fit are cut; the host makes room.
    const std::uint32_t place = min(begin + before, room);
    if (g.value < bins) c.members.next_bins[g] = {place, min(capacity, room - place)};
    begin += sum;
  }
  if (threadIdx.x == 0) c.counters().bins_wanted = begin;
}

}  // namespace

void launchAssignBins(const CycleArrays& cycle, const CycleShape& /*shape*/, cudaStream_t stream) {
  if (cycle.together()) return;
  binsKernel<<<1, kScanThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
