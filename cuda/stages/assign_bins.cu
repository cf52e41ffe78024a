// Stage assign, for the next cycle: how much room the tiles of each cluster are to have.
#include "cuda/device/block_prefix.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kScanThreads = 1024;

// What a cluster's tiles, and some more, take.
__device__ std::uint32_t wantedPlaces(const CycleArrays& c, ClusterIndex bin) {
  const std::uint32_t count = c.members.count(bin);
  constexpr std::uint32_t kSpare = 32;
  // Remembers peaks for a while, so that a scene that swings to and fro fits.
  const std::uint32_t before = c.members.bins[bin].wanted;
  return max(count + count / 4 + kSpare, before - before / 32);
}

// One block, which goes through the clusters: reads members.counts, and writes
// members.next_bins by an exclusive sum of the capacities. Room that nobody wants is shared out
// too: a bin that overflows costs a cycle.
__global__ void __launch_bounds__(kScanThreads) binsKernel(CycleArrays c) {
  const std::uint32_t bins = c.clusters.count, room = c.members.entries.size();
  std::uint32_t mine = 0, wanted;
  for (ClusterIndex g(threadIdx.x); g.value < bins; g.value += kScanThreads) {
    mine += wantedPlaces(c, g);
  }
  blockPrefix<kScanThreads>(mine, wanted);
  const std::uint32_t more = wanted < room ? (room - wanted) / bins : 0;
  std::uint32_t begin = 0;
  for (std::uint32_t first = 0; first < bins; first += kScanThreads) {
    const ClusterIndex g(first + threadIdx.x);
    const std::uint32_t its = g.value < bins ? wantedPlaces(c, g) : 0;
    const std::uint32_t capacity = g.value < bins ? its + more : 0;
    std::uint32_t sum;
    const std::uint32_t before = blockPrefix<kScanThreads>(capacity, sum);
    // Bins that do not fit are cut; the host makes room.
    const std::uint32_t place = min(begin + before, room);
    if (g.value < bins) c.members.next_bins[g] = {place, min(capacity, room - place), its};
    begin += sum;
  }
  if (threadIdx.x == 0) c.counters().bins_wanted = wanted;
}

}  // namespace

void launchAssignBins(const CycleArrays& cycle, const CycleShape& /*shape*/, cudaStream_t stream) {
  if (cycle.together()) return;
  binsKernel<<<1, kScanThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
