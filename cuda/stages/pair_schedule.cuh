// Schedules the pairs of tiles: decides which one a warp of the sweep's second part takes next.
#pragma once

#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Numbers the pieces of work: first each tile against itself, if any body may have contacts with
// itself, then dense pairs of tiles, then other pairs. If pairs are divided into parts, each part
// has a number. The struct lies in shared memory, because registers are scarce.
struct ScheduleNumbers {
  std::uint32_t tiles, dense_end, end;
  std::uint32_t log_dense_parts, log_parts;

  // Computes the numbers for a grid of `warps` warps.
  __device__ void set(const CycleArrays& c, std::uint32_t warps) {
    tiles = c.params().any_self != 0 ? c.scene.tile_count : 0;
    const std::uint32_t dense = min(c.counters().dense_pairs, c.sweep.dense_pairs.size());
    const std::uint32_t others = min(c.counters().tile_pairs, c.sweep.tile_pairs.size());
    const std::uint32_t most = kPartsEach * warps / max(tiles + dense + others, 1U);
    const std::uint32_t log_most = most == 0 ? 0 : 31 - __clz(static_cast<int>(most));
    log_parts = min(log_most, kMostLogParts);
    log_dense_parts = max(log_parts, dense <= kDenseEach * warps ? 1U : 0U);
    dense_end = tiles + (dense << log_dense_parts);
    end = dense_end + (others << log_parts);
  }

 private:
  // If pairs are few, they are divided into parts, at most kPartsEach for each warp. Otherwise the
  // last pair would keep one warp busy when the others have ended. A pair has at most
  // 2^kMostLogParts parts, because each part repeats the work at the beginning of a pair.
  static constexpr std::uint32_t kPartsEach = 4, kMostLogParts = 3;
  // Dense pairs are divided into at least two parts, unless there are more than so many for each
  // warp.
  static constexpr std::uint32_t kDenseEach = 2;
};

// Hands out numbers to one warp of a grid. The grid has one dimension; all lanes make each call.
class PairSchedule {
 public:
  __device__ PairSchedule(const CycleArrays& c, ScheduleNumbers& numbers)
      : c_(c), numbers_(numbers), turn_((blockIdx.x * blockDim.x + threadIdx.x) / kWarp) {
    if (laneId() == 0) numbers.set(c, warps());
    __syncwarp();
  }

  // Requests the next number. The first numbers are assigned in a fixed way, the others go to any
  // warp that is free. Some pairs have hundreds of triangles that meet; most have few, and those
  // come last. Call it when the last pair's triangles have been taken, so that other work hides the
  // latency.
  __device__ void askForNext() {
    if (laneId() == 0 && number_ + 1 >= run_end_) {
      turn_ = warps() + atomicAdd(&c_.counters().pairs_taken, 1U);
    }
  }
  // Moves on to the next number of this run, or to another run. Returns false if none is left.
  __device__ bool take() {
    if (++number_ >= run_end_) beginRun();
    return number_ < numbers_.end;
  }

  __device__ std::uint32_t number() const { return number_; }
  // Returns whether the work is tile() against itself. Otherwise it is part() of the parts() parts
  // of pair().
  __device__ bool isSelf() const { return number_ < numbers_.tiles; }
  __device__ TileIndex tile() const { return TileIndex(number_); }
  __device__ const TilePair& pair() const {
    const Place place(numberOfKind() >> logParts());
    return isDense() ? c_.sweep.dense_pairs[place] : c_.sweep.tile_pairs[place];
  }
  __device__ std::uint32_t part() const { return numberOfKind() & (parts() - 1); }
  __device__ std::uint32_t parts() const { return 1U << logParts(); }

 private:
  // Other pairs are taken in runs of kRun, except the last kRun * warps() of them, which are taken
  // singly. Additions to one counter are made one after the other, so a hundred thousand of them
  // would make all warps wait.
  static constexpr std::uint32_t kRun = 4;

  __device__ static std::uint32_t warps() { return gridDim.x * (blockDim.x / kWarp); }
  __device__ bool isDense() const { return number_ < numbers_.dense_end; }
  __device__ std::uint32_t numberOfKind() const {
    return number_ - (isDense() ? numbers_.tiles : numbers_.dense_end);
  }
  __device__ std::uint32_t logParts() const {
    return isDense() ? numbers_.log_dense_parts : numbers_.log_parts;
  }

  __device__ void beginRun() {
    number_ = __shfl_sync(kFullWarp, turn_, 0);
    run_end_ = number_ + 1;
    if (isDense()) return;
    const std::uint32_t others = numbers_.end - numbers_.dense_end;
    const std::uint32_t runs = (others - min(others, kRun * warps())) / kRun;
    const std::uint32_t ahead = min(number_ - numbers_.dense_end, runs);
    number_ += ahead * (kRun - 1);
    run_end_ = number_ + (ahead < runs ? kRun : 1);
  }

  const CycleArrays& c_;
  const ScheduleNumbers& numbers_;
  // The next turn of this warp, in the first lane. It is a number, except that a run counts as one.
  std::uint32_t turn_;
  std::uint32_t number_ = 0, run_end_ = 0;
};

}  // namespace deformable_contact_monitor
