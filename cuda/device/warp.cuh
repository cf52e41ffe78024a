// Computes sums, maxima and reservations over the threads of a warp or a block.
#pragma once

#include <cstdint>

namespace deformable_contact_monitor {

constexpr unsigned kWarp = 32;
constexpr unsigned kFullWarp = 0xffffffffU;

__device__ inline unsigned laneId() { return threadIdx.x % kWarp; }

// Returns the value of the first lane. What other warps change may be read differently by lanes,
// and a warp must not part over it. Called by a whole warp.
template <class T>
__device__ inline T sameInWarp(T value) {
  return __shfl_sync(kFullWarp, value, 0);
}

// Returns the greatest x of all lanes. Called by a whole warp.
__device__ inline std::uint32_t warpMost(std::uint32_t x) {
#if __CUDA_ARCH__ >= 800
  return __reduce_max_sync(kFullWarp, x);
#else
  for (unsigned o = kWarp / 2; o > 0; o /= 2) x = max(x, __shfl_xor_sync(kFullWarp, x, o));
  return x;
#endif
}

// Returns the sum of x over all lanes, in each of them. Called by a whole warp.
template <class T>
__device__ inline T warpSum(T x) {
  for (unsigned o = kWarp / 2; o > 0; o /= 2) x += __shfl_xor_sync(kFullWarp, x, o);
  return x;
}

// Returns the sum of x over the lanes before this one; `total` becomes the sum over all lanes.
// Called by a whole warp.
__device__ inline std::uint32_t warpPrefix(std::uint32_t x, std::uint32_t& total) {
  std::uint32_t sum = x;
  for (unsigned o = 1; o < kWarp; o *= 2) {
    const std::uint32_t before = __shfl_up_sync(kFullWarp, sum, o);
    if (laneId() >= o) sum += before;
  }
  total = __shfl_sync(kFullWarp, sum, kWarp - 1);
  return sum - x;
}

// A counter of 32 bits that tells the length of a list stops growing about here, so that it cannot
// wrap and seem small. No list has so many places.
constexpr std::uint32_t kMostCounted = 1U << 30;

// Adds to the counter of a list, and returns what it was. The counter is not less than kMostCounted
// from the time on when it has passed it.
__device__ inline std::uint32_t reserve(std::uint32_t* counter, std::uint32_t places) {
  const std::uint32_t first = atomicAdd(counter, places);
  if (first >= kMostCounted) atomicMin(counter, kMostCounted);
  return first;
}
__device__ inline unsigned long long reserve(unsigned long long* counter, std::uint32_t places) {
  return atomicAdd(counter, static_cast<unsigned long long>(places));
}

// Reserves one place for each lane of a whole warp that wants it, with one atomic; returns it.
// Counter is an unsigned integer of 32 or 64 bits.
template <class Counter>
__device__ inline Counter warpReserve(Counter* counter, bool wanted) {
  const unsigned mask = __ballot_sync(kFullWarp, wanted);
  Counter base = 0;
  if (mask == 0) return 0;
  if (laneId() == 0) base = reserve(counter, __popc(mask));
  return __shfl_sync(kFullWarp, base, 0) + __popc(mask & ((1U << laneId()) - 1));
}

// Counts the lanes of a whole warp for which `counted` holds, with at most one atomic.
__device__ inline void warpCount(std::uint32_t* counter, bool counted) {
  const unsigned mask = __ballot_sync(kFullWarp, counted);
  if (mask != 0 && laneId() == 0) atomicAdd(counter, __popc(mask));
}

// Returns the sum of x over the threads before this one; `total` becomes the sum over all. Called
// by the whole block of kThreads threads, in whole warps.
template <unsigned kThreads>
__device__ std::uint32_t blockPrefix(std::uint32_t x, std::uint32_t& total) {
  __shared__ std::uint32_t warp_total[kThreads / kWarp];
  std::uint32_t before = warpPrefix(x, total);
  __syncthreads();  // other threads may still read the last call's totals
  if (laneId() == 0) warp_total[threadIdx.x / kWarp] = total;
  __syncthreads();
  total = 0;
  for (unsigned w = 0; w < kThreads / kWarp; ++w) {
    before += w < threadIdx.x / kWarp ? warp_total[w] : 0;
    total += warp_total[w];
  }
  return before;
}

}  // namespace deformable_contact_monitor
