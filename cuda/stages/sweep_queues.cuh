// The queues of a warp that sweeps, in shared memory: they are short, and each test runs on a full
// warp of what they hold.
#pragma once

#include <cstdint>

#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_params.cuh"
#include "cuda/memory/sweep_arrays.cuh"

namespace deformable_contact_monitor {

// A stack. `size` is the same in all lanes.
template <class T, unsigned kCapacity>
struct WarpQueue {
  T* items;
  unsigned size = 0;

  // Takes an item from each lane that has one.
  __device__ void push(bool has, const T& item) {
    const unsigned mask = __ballot_sync(kFullWarp, has);
    if (has) items[size + __popc(mask & ((1U << laneId()) - 1))] = item;
    size += __popc(mask);
    __syncwarp();
  }
  // Removes up to a warp of items; true in the lanes that got one.
  __device__ bool pop(T& item) {
    const unsigned taken = min(size, kWarp);
    size -= taken;
    const bool got = laneId() < taken;
    if (got) item = items[size + laneId()];
    __syncwarp();
    return got;
  }
};

// How many columns of each row are swept at once.
constexpr std::uint32_t kStep = 16;

// Rows and columns of a unit that meet along the cluster's axes.
struct HitMemory {
  // The hits of a step, and what is less than a warp of them.
  static constexpr std::uint32_t kCapacity = kWarp * (kStep + 1);

  // Lane of the row | column in the unit << 5 | which of two units << 15.
  static_assert(kMostUnitColumns <= 1U << 10);
  std::uint16_t hits[kCapacity];
  // Of each of the two units: the first column of each lane's row, and what all rows have.
  std::uint32_t first_column[2][kWarp];
  struct Unit {
    SortedIndex first_row;
    ClusterIndex cluster;
  } units[2];
};

// A pair of places among the sorted members of a cluster.
struct Hit {
  SortedIndex row, column;
  ClusterIndex cluster;
};

// First in, first out: what is left of a unit, less than a warp, is joined by hits of the next one.
class HitQueue {
 public:
  __device__ explicit HitQueue(HitMemory& memory) : memory_(memory) {}
  __device__ std::uint32_t size() const { return size_; }
  // Whether there are hits of the unit before the one begun last: they must go before another
  // begins.
  __device__ bool hasOlder() const { return older_ > 0; }

  // From here on hits are those of this unit; `first_column` is that of the lane's row.
  __device__ void begin(const WorkUnit& unit, std::uint32_t first_column) {
    older_ = size_;
    unit_ ^= 1;
    memory_.first_column[unit_][laneId()] = first_column;
    if (laneId() == 0) memory_.units[unit_] = {unit.first_row, unit.cluster};
    __syncwarp();
  }
  // Of the lane's row those columns, counted from `column` on, whose bits are set.
  __device__ void push(unsigned mask, std::uint32_t column) {
    std::uint32_t total;
    std::uint32_t place = first_ + size_ + warpPrefix(__popc(mask), total);
    for (; mask != 0; mask &= mask - 1) {
      const std::uint32_t k = __ffs(static_cast<int>(mask)) - 1;
      memory_.hits[wrapped(place++)] =
          static_cast<std::uint16_t>(laneId() | (column + k) << 5 | unit_ << 15);
    }
    size_ += total;
    __syncwarp();
  }
  // Removes up to a warp of hits; true in the lanes that got one.
  __device__ bool pop(Hit& hit) {
    const std::uint32_t taken = min(size_, kWarp);
    const bool got = laneId() < taken;
    if (got) {
      const std::uint32_t packed = memory_.hits[wrapped(first_ + laneId())];
      const std::uint32_t lane = packed & 31, unit = packed >> 15;
      hit.row = memory_.units[unit].first_row + lane;
      hit.column = SortedIndex(memory_.first_column[unit][lane] + (packed >> 5 & 0x3ff));
      hit.cluster = memory_.units[unit].cluster;
    }
    first_ = wrapped(first_ + taken);
    size_ -= taken;
    older_ -= min(older_, taken);
    __syncwarp();
    return got;
  }

 private:
  __device__ static std::uint32_t wrapped(std::uint32_t place) {
    return place < HitMemory::kCapacity ? place : place - HitMemory::kCapacity;
  }

  HitMemory& memory_;
  std::uint32_t first_ = 0, size_ = 0;
  std::uint32_t older_ = 0;  // of another unit than unit_
  std::uint32_t unit_ = 0;
};

}  // namespace deformable_contact_monitor
