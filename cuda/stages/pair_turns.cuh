// Which pair of tiles a warp of stage pairs takes next.
#pragma once

#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// How turns are numbered: tiles with themselves, if any body has contacts with itself, then crowded
// pairs of tiles, then the other pairs; a pair that comes in parts has a number for each. In shared
// memory, for registers are scarce.
struct TurnNumbers {
  std::uint32_t tiles, crowded_end, end;
  std::uint32_t log_crowded_parts, log_parts;

  // For a grid of so many warps.
  __device__ void set(const CycleArrays& c, std::uint32_t warps) {
    tiles = c.params().any_self != 0 ? c.scene.tile_count : 0;
    const std::uint32_t crowded = min(c.counters().crowded_pairs, c.sweep.crowded_pairs.size());
    const std::uint32_t others = min(c.counters().tile_pairs, c.sweep.tile_pairs.size());
    const std::uint32_t most = kPartsEach * warps / max(tiles + crowded + others, 1U);
    const std::uint32_t log_most = most == 0 ? 0 : 31 - __clz(static_cast<int>(most));
    log_parts = min(log_most, kMostLogParts);
    log_crowded_parts = max(log_parts, crowded <= kCrowdedEach * warps ? 1U : 0U);
    crowded_end = tiles + (crowded << log_crowded_parts);
    end = crowded_end + (others << log_parts);
  }

 private:
  // Where pairs are few they come in parts, no more than so many for each warp in all: else the
  // last of them would keep one warp busy when the others have ended. But at most so many, for each
  // begins with what takes as long for a whole pair.
  static constexpr std::uint32_t kPartsEach = 4, kMostLogParts = 3;
  // Crowded pairs come in two parts at least, where they are no more than so many for each warp.
  static constexpr std::uint32_t kCrowdedEach = 2;
};

// For one warp of a grid of one dimension, all of whose lanes make each of the calls.
class PairTurns {
 public:
  __device__ PairTurns(const CycleArrays& c, TurnNumbers& numbers)
      : c_(c), numbers_(numbers), turn_((blockIdx.x * blockDim.x + threadIdx.x) / kWarp) {
    if (laneId() == 0) numbers.set(c, warps());
    __syncwarp();
  }

  // The first turns are dealt out, the others go to whoever is free: some pairs have hundreds of
  // triangles that meet, most have few, and those come last. To be asked for when the last pair's
  // triangles have been taken: until it is wanted there is other work to do.
  __device__ void askForNext() {
    if (laneId() == 0 && number_ + 1 >= run_end_) {
      turn_ = warps() + atomicAdd(&c_.counters().pairs_taken, 1U);
    }
  }
  // To the next number, of this run or, in turn, of another; false if there is none left.
  __device__ bool take() {
    if (++number_ >= run_end_) beginRun();
    return number_ < numbers_.end;
  }

  __device__ std::uint32_t number() const { return number_; }
  // A tile with itself; else pair(), of which it is one of so many parts.
  __device__ bool isSelf() const { return number_ < numbers_.tiles; }
  __device__ TileIndex tile() const { return TileIndex(number_); }
  __device__ const TilePair& pair() const {
    const Place place(numberOfKind() >> logParts());
    return isCrowded() ? c_.sweep.crowded_pairs[place] : c_.sweep.tile_pairs[place];
  }
  __device__ std::uint32_t part() const { return numberOfKind() & (parts() - 1); }
  __device__ std::uint32_t parts() const { return 1U << logParts(); }

 private:
  // The other pairs are taken by runs of so many, but for the last, so many for each warp: a
  // hundred thousand additions to one counter come one after the other, and everybody waits for
  // them.
  static constexpr std::uint32_t kRun = 4;

  __device__ static std::uint32_t warps() { return gridDim.x * (blockDim.x / kWarp); }
  __device__ bool isCrowded() const { return number_ < numbers_.crowded_end; }
  __device__ std::uint32_t numberOfKind() const {
    return number_ - (isCrowded() ? numbers_.tiles : numbers_.crowded_end);
  }
  __device__ std::uint32_t logParts() const {
    return isCrowded() ? numbers_.log_crowded_parts : numbers_.log_parts;
  }

  __device__ void beginRun() {
    number_ = __shfl_sync(kFullWarp, turn_, 0);
    run_end_ = number_ + 1;
    if (isCrowded()) return;
    const std::uint32_t others = numbers_.end - numbers_.crowded_end;
    const std::uint32_t runs = (others - min(others, kRun * warps())) / kRun;
    const std::uint32_t ahead = min(number_ - numbers_.crowded_end, runs);
    number_ += ahead * (kRun - 1);
    run_end_ = number_ + (ahead < runs ? kRun : 1);
  }

  const CycleArrays& c_;
  const TurnNumbers& numbers_;
  std::uint32_t turn_;  // in the first lane: a number, but that each run has one
  std::uint32_t number_ = 0, run_end_ = 0;
};

}  // namespace deformable_contact_monitor
