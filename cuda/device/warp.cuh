// Small tools for warps.
#pragma once

#include <cstdint>

namespace deformable_contact_monitor {

constexpr unsigned kWarp = 32;
constexpr unsigned kFullWarp = 0xffffffffU;

__device__ inline unsigned laneId() { return threadIdx.x % kWarp; }

__device__ inline std::uint32_t warpMost(std::uint32_t x) {
#if __CUDA_ARCH__ >= 800
  return __reduce_max_sync(kFullWarp, x);
#else
  for (unsigned o = kWarp / 2; o > 0; o /= 2) x = max(x, __shfl_xor_sync(kFullWarp, x, o));
  return x;
#endif
}

template <class T>
__device__ inline T warpSum(T x) {
  for (unsigned o = kWarp / 2; o > 0; o /= 2) x += __shfl_xor_sync(kFullWarp, x, o);
  return x;
}

// The sum of x over the lanes before this one; `total` becomes that over all.
__device__ inline std::uint32_t warpPrefix(std::uint32_t x, std::uint32_t& total) {
  std::uint32_t sum = x;
  for (unsigned o = 1; o < kWarp; o *= 2) {
    const std::uint32_t before = __shfl_up_sync(kFullWarp, sum, o);
    if (laneId() >= o) sum += before;
  }
  total = __shfl_sync(kFullWarp, sum, kWarp - 1);
  return sum - x;
}

// Reserves one place for each lane of a whole warp that wants it, with one atomic; returns it.
// Counter is an unsigned integer of 32 or 64 bits.
template <class Counter>
__device__ inline Counter warpReserve(Counter* counter, bool wanted) {
  const unsigned mask = __ballot_sync(kFullWarp, wanted);
  Counter base = 0;
  if (mask == 0) return 0;
  if (laneId() == 0) base = atomicAdd(counter, static_cast<Counter>(__popc(mask)));
  return __shfl_sync(kFullWarp, base, 0) + __popc(mask & ((1U << laneId()) - 1));
}

// Adds up over a whole warp, with at most one atomic.
__device__ inline void warpCount(std::uint32_t* counter, bool counted) {
  const unsigned mask = __ballot_sync(kFullWarp, counted);
  if (mask != 0 && laneId() == 0) atomicAdd(counter, __popc(mask));
}

}  // namespace deformable_contact_monitor
