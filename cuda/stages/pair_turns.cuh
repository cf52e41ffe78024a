// Which pair of tiles a warp of stage pairs takes next.
#pragma once

#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// For one warp of a grid of one dimension, all of whose lanes make each of the calls. Work has
// numbers: tiles with themselves, if any body has contacts with itself, then parts of crowded pairs
// of tiles, then the other pairs.
class PairTurns {
 public:
  __device__ explicit PairTurns(const CycleArrays& c)
      : c_(c), turn_((blockIdx.x * blockDim.x + threadIdx.x) / kWarp) {
    tiles_ = c.params().any_self != 0 ? c.scene.tile_count : 0;
    const std::uint32_t crowded = min(c.counters().crowded_pairs, c.sweep.crowded_pairs.size());
    parts_ = min(max(kPartsEach * warps() / max(crowded, 1U), 1U), kMostParts);
    crowded_ = tiles_ + parts_ * crowded;
    end_ = crowded_ + min(c.counters().tile_pairs, c.sweep.tile_pairs.size());
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
    return number_ < end_;
  }

  __device__ std::uint32_t number() const { return number_; }
  // A tile with itself; else pair(), of which it is one of so many parts.
  __device__ bool isSelf() const { return number_ < tiles_; }
  __device__ TileIndex tile() const { return TileIndex(number_); }
  __device__ const TilePair& pair() const {
    if (isCrowded()) return c_.sweep.crowded_pairs[Place((number_ - tiles_) / parts_)];
    return c_.sweep.tile_pairs[Place(number_ - crowded_)];
  }
  __device__ std::uint32_t part() const { return isCrowded() ? (number_ - tiles_) % parts_ : 0; }
  __device__ std::uint32_t parts() const { return isCrowded() ? parts_ : 1; }

 private:
  // Crowded pairs come in parts, at most so many, where that makes no more than so many for each
  // warp: else the last of them would keep one warp busy when the others have ended.
  static constexpr std::uint32_t kMostParts = 2, kPartsEach = 4;
  // The other pairs are taken by runs of so many, but for the last, so many for each warp: a
  // hundred thousand additions to one counter come one after the other, and everybody waits for
  // them.
  static constexpr std::uint32_t kRun = 4;

  __device__ static std::uint32_t warps() { return gridDim.x * (blockDim.x / kWarp); }
  __device__ bool isCrowded() const { return number_ < crowded_; }

  __device__ void beginRun() {
    number_ = __shfl_sync(kFullWarp, turn_, 0);
    run_end_ = number_ + 1;
    if (number_ < crowded_) return;
    const std::uint32_t others = end_ - crowded_;
    const std::uint32_t runs = (others - min(others, kRun * warps())) / kRun;
    const std::uint32_t ahead = min(number_ - crowded_, runs);
    number_ += ahead * (kRun - 1);
    run_end_ = number_ + (ahead < runs ? kRun : 1);
  }

  const CycleArrays& c_;
  std::uint32_t tiles_, parts_, crowded_, end_;
  std::uint32_t turn_;  // in the first lane: a number, but that each run has one
  std::uint32_t number_ = 0, run_end_ = 0;
};

}  // namespace deformable_contact_monitor
