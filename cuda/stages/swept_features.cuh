// Hands out the features of moving pairs to the threads of a kernel, in swept motion. Kernels that
// examine features (narrow_phase_features.cu, narrow_phase_roots.cu) have kFeatureThreads a block.
#pragma once

#include "core/predicates/swept_feature.h"
#include "cuda/stages/narrow_phase_moving.cuh"

namespace deformable_contact_monitor {

constexpr unsigned kFeatureThreads = 128;
constexpr unsigned kFeatureWarps = kFeatureThreads / kWarp;

// One feature of a candidate.
struct FeatureTask {
  Place candidate;
  std::uint32_t index;  // as in featureOf()
};

// A queue of one warp, in shared memory; `size` is the same in all lanes.
struct TaskQueue {
  FeatureTask* items;
  unsigned size;

  __device__ void push(bool has, const FeatureTask& task) {
    const unsigned mask = __ballot_sync(kFullWarp, has);
    if (has) items[size + __popc(mask & ((1U << laneId()) - 1))] = task;
    size += __popc(mask);
    __syncwarp();
  }
  // Gives a task to each idle lane, as long as there are some. Returns true in the lanes that get
  // one.
  __device__ bool pop(bool idle, FeatureTask& task) {
    const unsigned mask = __ballot_sync(kFullWarp, idle);
    const unsigned rank = __popc(mask & ((1U << laneId()) - 1));
    const bool got = idle && rank < size;
    if (got) task = items[size - 1 - rank];
    size -= min(size, static_cast<unsigned>(__popc(mask)));
    __syncwarp();
    return got;
  }
};

constexpr std::uint32_t kVertexFaces = 6;  // the number of such features; they come first
__device__ inline bool isVertexFace(const FeatureTask& task) { return task.index < kVertexFaces; }

__device__ inline MovingPoint pointAt(const CycleArrays& c, TileEntryIndex at, int i) {
  return {c.tiles.earlier[at].posed.v[i], c.tiles.entries[at].posed.v[i]};
}

// Returns a feature as featureOf() does, but reads its points from memory. Triangles in registers
// could not be indexed by a number that is only known at run time.
__device__ inline Feature featureAt(const CycleArrays& c, const FeatureTask& task) {
  const DeviceCandidate pair = c.contacts.candidates[task.candidate];
  const int index = static_cast<int>(task.index);
  if (isVertexFace(task)) {
    const TileEntryIndex face = index < 3 ? pair.a : pair.b, other = index < 3 ? pair.b : pair.a;
    return {FeatureKind::kVertexFace,
            {pointAt(c, face, 0), pointAt(c, face, 1), pointAt(c, face, 2),
             pointAt(c, other, index < 3 ? index : index - 3)}};
  }
  const int i = (index - 6) / 3, j = (index - 6) % 3;
  return {FeatureKind::kEdgeEdge,
          {pointAt(c, pair.a, i), pointAt(c, pair.a, i == 2 ? 0 : i + 1), pointAt(c, pair.b, j),
           pointAt(c, pair.b, j == 2 ? 0 : j + 1)}};
}

__device__ inline bool hasMet(const SweptState& state) {
  return state.high <= __float_as_uint(1.0F);
}

// Reads a value that other threads may change meanwhile.
__device__ inline float highOf(const CycleArrays& c, Place candidate) {
  const volatile std::uint32_t& high = c.contacts.states[candidate].high;
  return __uint_as_float(high);
}

// Returns whether a pair needs no more features: one has met, and the time is not asked for.
__device__ inline bool isDecided(const CycleArrays& c, Place candidate, bool wants_time) {
  return !wants_time && highOf(c, candidate) <= 1;
}

// Tells the kernels that no feature of the pair that meets later is of interest.
__device__ inline void lowerHigh(const CycleArrays& c, Place candidate, float high) {
  atomicMin(&c.contacts.states[candidate].high, __float_as_uint(high));
}

// Lowers the pair's time interval to that of a feature that meets, if it is earlier. Many threads
// may do so at the same time.
__device__ inline void addMeeting(const CycleArrays& c, Place candidate,
                                  const FeatureVerdict& verdict) {
  SweptState& state = c.contacts.states[candidate];
  atomicMin(&state.low, __float_as_uint(verdict.low));
  lowerHigh(c, candidate, verdict.high);
}

// Marks the lanes' features for which `left` is set as open. A pair that had no such feature is
// added to first_list. Called by a whole warp.
__device__ inline void leaveFeature(const CycleArrays& c, const FeatureTask& task, bool left) {
  std::uint32_t before = kFeatureBits;
  if (left) before = atomicOr(&c.contacts.states[task.candidate].bits, 1U << task.index);
  append(c.contacts.first_list, &sweptCounters(c).left, (before & kFeatureBits) == 0,
         task.candidate);
}

// Returns whether roots of cubics are looked for at once. For few pairs without times, a kernel
// more takes longer than it saves.
__device__ inline bool looksForRoots(const CycleArrays& c) {
  constexpr std::uint32_t kManyPairs = 16384;
  return c.params().first_times != 0 || sweptCounters(c).featured >= kManyPairs;
}

// Where roots are looked for, DeviceCandidate::facts has a bit for each feature for which float32
// is not certain when it meets at the earliest, to 1 / 2^kRootHalvings<float>. These pairs share no
// vertices, and the bits of shared vertices stay 0. `features`: a bit for each.
__device__ inline std::uint32_t uncertainBits(std::uint32_t features) {
  constexpr std::uint32_t kFirst = (1U << kSharedShift) - 1;
  return (features & kFirst) | (features & ~kFirst) << 6;
}
__device__ inline void markUncertain(const CycleArrays& c, const FeatureTask& task) {
  atomicOr(&c.contacts.candidates[task.candidate].facts, uncertainBits(1U << task.index));
}
__device__ inline void markCertain(const CycleArrays& c, const FeatureTask& task) {
  atomicAnd(&c.contacts.candidates[task.candidate].facts, ~uncertainBits(1U << task.index));
}
__device__ inline bool isUncertain(const CycleArrays& c, const FeatureTask& task) {
  return (c.contacts.candidates[task.candidate].facts & uncertainBits(1U << task.index)) != 0;
}

// Hands out the features that bits of SweptState name, for the pairs of a list, to one warp. Each
// lane has one pair and hands out one feature at a time. Edges against edges come first: they are
// more likely to meet, and the first feature that meets may decide the pair.
class FeatureSource {
 public:
  // `bits_at`: the lowest of these bits in SweptState::bits. `takes`: clears them.
  __device__ FeatureSource(const CycleArrays& c, const DeviceArray<Place, Place>& list,
                           std::uint32_t count, unsigned bits_at, bool takes = false)
      : c_(c),
        list_(list),
        count_(count),
        bits_at_(bits_at),
        takes_(takes),
        warps_(gridDim.x * kFeatureWarps) {
    // Spreads few pairs over many warps, and gives all warps equally many.
    const std::uint32_t each = max(1U, (count + warps_ - 1) / warps_);
    const std::uint32_t rounds = (each + kWarp - 1) / kWarp;
    pairs_ = (each + rounds - 1) / rounds;
    first_ = (blockIdx.x * kFeatureThreads + threadIdx.x) / kWarp * pairs_;
    more_ = first_ < count_;
  }
  __device__ bool hasMore() const { return more_; }

  // Sets `task` to the lane's next feature; returns false if it has none. Called by the whole warp.
  __device__ bool next(FeatureTask& task) {
    if (__ballot_sync(kFullWarp, rest_ != 0) == 0) takePairs();
    const bool has = rest_ != 0;
    if (has) {
      const std::uint32_t edges = rest_ >> kVertexFaces;
      task = {pair_, edges != 0 ? kVertexFaces + lowest(edges) : lowest(rest_)};
      rest_ &= ~(1U << task.index);
    }
    more_ = first_ < count_ || __ballot_sync(kFullWarp, rest_ != 0) != 0;
    return has;
  }

 private:
  __device__ static std::uint32_t lowest(std::uint32_t bits) {
    return static_cast<std::uint32_t>(__ffs(static_cast<int>(bits)) - 1);
  }
  __device__ void takePairs() {
    const std::uint32_t k = first_ + laneId();
    if (laneId() < pairs_ && k < count_) {
      pair_ = list_[Place(k)];
      std::uint32_t& bits = c_.contacts.states[pair_].bits;
      rest_ = (takes_ ? atomicAnd(&bits, ~(kFeatureBits << bits_at_)) : bits) >> bits_at_ &
              kFeatureBits;
    }
    first_ += warps_ * pairs_;
  }

  const CycleArrays& c_;
  const DeviceArray<Place, Place>& list_;
  std::uint32_t count_;
  unsigned bits_at_;
  bool takes_;
  std::uint32_t warps_, pairs_, first_;
  bool more_;
  Place pair_{0};
  std::uint32_t rest_ = 0;
};

}  // namespace deformable_contact_monitor
