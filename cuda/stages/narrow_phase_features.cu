// Stage narrow_phase in swept motion, second part: examines the features (vertex against face, edge
// against edge) of the pairs that the first part leaves. One thread works on one feature at a time:
// first in float32, then in double, then by integers. The rest is left to the host.
#include "cuda/stages/halving.cuh"
#include "cuda/stages/narrow_phase_moving.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;
// A warp with at least so many idle lanes fetches more features.
constexpr unsigned kHungry = 20;

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

__device__ MovingPoint pointAt(const CycleArrays& c, TileEntryIndex at, int i) {
  return {c.tiles.earlier[at].posed.v[i], c.tiles.entries[at].posed.v[i]};
}

// Returns a feature as featureOf() does, but reads its points from memory. Triangles in registers
// could not be indexed by a number that is only known at run time.
__device__ Feature featureAt(const CycleArrays& c, const FeatureTask& task) {
  const DeviceCandidate pair = c.contacts.candidates[task.candidate];
  const int index = static_cast<int>(task.index);
  if (index < 6) {
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

__device__ bool hasMet(const SweptState& state) { return state.high <= __float_as_uint(1.0F); }

// Reads a value that other threads may change meanwhile.
__device__ float highOf(const CycleArrays& c, Place candidate) {
  const volatile std::uint32_t& high = c.contacts.states[candidate].high;
  return __uint_as_float(high);
}

// Lowers the pair's time interval to that of a feature that meets, if it is earlier. Many threads
// may do so at the same time.
__device__ void addMeeting(const CycleArrays& c, Place candidate, const FeatureVerdict& verdict) {
  SweptState& state = c.contacts.states[candidate];
  atomicMin(&state.low, __float_as_uint(verdict.low));
  atomicMin(&state.high, __float_as_uint(verdict.high));
}

// Hands out the features that bits of SweptState name, for the pairs of a list, to one warp. Each
// lane has one pair and hands out one feature at a time. Edges against edges come first: they are
// more likely to meet, and the first feature that meets may decide the pair.
class FeatureSource {
 public:
  // `bits_at`: the lowest of these bits in SweptState::bits.
  __device__ FeatureSource(const CycleArrays& c, const DeviceArray<Place, Place>& list,
                           std::uint32_t count, unsigned bits_at)
      : c_(c), list_(list), count_(count), bits_at_(bits_at), warps_(gridDim.x * kWarps) {
    pairs_ = max(1U, min(kWarp, count / warps_));  // spreads few pairs over many warps
    first_ = (blockIdx.x * kThreads + threadIdx.x) / kWarp * pairs_;
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
  static constexpr std::uint32_t kVertexFaces = 6;
  __device__ static std::uint32_t lowest(std::uint32_t bits) {
    return static_cast<std::uint32_t>(__ffs(static_cast<int>(bits)) - 1);
  }
  __device__ void takePairs() {
    const std::uint32_t k = first_ + laneId();
    if (laneId() < pairs_ && k < count_) {
      pair_ = list_[Place(k)];
      rest_ = c_.contacts.states[pair_].bits >> bits_at_ & kFeatureBits;
    }
    first_ += warps_ * pairs_;
  }

  const CycleArrays& c_;
  const DeviceArray<Place, Place>& list_;
  std::uint32_t count_;
  unsigned bits_at_;
  std::uint32_t warps_, pairs_, first_;
  bool more_;
  Place pair_{0};
  std::uint32_t rest_ = 0;
};

// Returns whether a pair needs no more features: one has met, and the time is not asked for.
__device__ bool isDecided(const CycleArrays& c, Place candidate, bool wants_time) {
  return !wants_time && highOf(c, candidate) <= 1;
}

struct HalvingLimits {
  bool wants_time;
  int most_pieces;
};

// Halves the features of a source (halving.cuh), except those of pairs that are decided.
// takes(task, coplanarity) may reject a feature; finish(task, verdict) gets the verdicts on the
// others. Lanes that are done wait until kHungry are idle; then all of them get new features from a
// queue, so that the code that begins features runs on many lanes at once.
template <class Real, class Takes, class Finish>
__device__ void halveFeatures(const CycleArrays& c, FeatureSource source,
                              const HalvingLimits& limits, const Takes& takes,
                              const Finish& finish) {
  __shared__ FeatureTask items[kWarps][2 * kWarp];
  const std::uint32_t warp = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  const float narrow = limits.wants_time ? 1.0F / (1 << kTimeHalvings) : 1.0F;
  TaskQueue queue{items[threadIdx.x / kWarp], 0};
  FeatureTask task{};
  Halving<Real> halving;
  detail::ErrorsOfHalving<Real> errors;
  bool active = false;
  for (std::uint32_t turn = 0;; ++turn) {
    const unsigned idle = __popc(__ballot_sync(kFullWarp, !active));
    if (idle >= kHungry) {
      if (queue.size < idle && source.hasMore()) {
        FeatureTask found{};
        const bool wanted = source.next(found) && !isDecided(c, found.candidate, limits.wants_time);
        queue.push(wanted, found);
        continue;
      }
      if (queue.size > 0) {
        if (queue.pop(!active, task)) {
          const Feature feature = featureAt(c, task);
          const Cubic<Real> d = coplanarity<Real>(feature);
          if (takes(task, d)) {
            active = halving.begin(feature, d);
            if (active) {
              errors = halving.errors();
            } else {
              finish(task, FeatureVerdict{});
            }
          }
        }
      } else if (idle == kWarp) {
        return;
      }
    }
    if (turn % 64 == 63 && warpIsCutOff(c, warp % kWarpsPerAsker == 0)) return;
    if (!active) continue;
    const float high = highOf(c, task.candidate);
    if (!limits.wants_time && high <= 1) {
      active = false;
      continue;
    }
    const HalvingStep step = halving.step(narrow, high, limits.most_pieces, errors);
    if (step == HalvingStep::kGoesOn) continue;
    if (step == HalvingStep::kGoesBack) {
      const Feature feature = featureAt(c, task);
      halving.goBack(feature, coplanarity<Real>(feature));
      continue;
    }
    active = false;
    const float low = halving.low();
    finish(task, step == HalvingStep::kMeets
                     ? FeatureVerdict{PartVerdict::kMeet, low, low + halving.width()}
                 : step == HalvingStep::kOpen ? FeatureVerdict{PartVerdict::kOpen, low, 1}
                                              : FeatureVerdict{});
  }
}

// Returns whether all coefficients are within the error bound, so that no part of the cubic can
// have a certain sign.
template <class Real>
__device__ bool isLost(const Cubic<Real>& d) {
  bool lost = true;
  for (const Real x : d.c) lost = lost && !(sizeOf(x) > d.error);
  return lost;
}

// One thread for each of contacts.second_list: marks the features that their boxes and the signs of
// their cubics leave open.
__global__ void __launch_bounds__(kThreads) signsKernel(CycleArrays c) {
  forEachByWarp(c, sweptCounters(c).featured, [&](Place k, bool there) {
    if (!there) return;
    const Place i = c.contacts.second_list[k];
    const DeviceCandidate pair = c.contacts.candidates[i];
    const MovingTriangle a = movingAt(c, pair.a), b = movingAt(c, pair.b);
    const FeatureBoxes boxes(a, b);
    std::uint32_t bits = 0;
#pragma unroll
    for (int f = 0; f < kFeatures; ++f) {
      if (boxes.areApart(f)) continue;
      if (coplanarity<float>(featureOf(a, b, f)).sign() == 0) bits |= 1U << f;
    }
    c.contacts.states[i].bits |= bits << kLeftAt;
  });
}

// Examines the features that signsKernel left, in float32. Pairs with open features are added to
// first_list.
__global__ void __launch_bounds__(kThreads) featureKernel(CycleArrays c) {
  const CycleParams& params = c.params();
  const bool wants_time = params.first_times != 0;
  const bool fast = params.predicates == Predicates::kFast;
  const int most_in_float = wants_time ? 64 : 16;  // double continues
  const auto leaveOpen = [&c, fast](const FeatureTask& task, float low) {
    SweptState& state = c.contacts.states[task.candidate];
    const std::uint32_t before = atomicOr(&state.bits, 1U << task.index);
    if (fast) {
      atomicMin(&state.open_low, __float_as_uint(low));
    } else if ((before & kFeatureBits) == 0) {
      c.contacts.first_list[Place(atomicAdd(&sweptCounters(c).left, 1U))] = task.candidate;
    }
  };
  halveFeatures<float>(
      c, FeatureSource(c, c.contacts.second_list, sweptCounters(c).featured, kLeftAt),
      {wants_time, fast ? kMostPieces : most_in_float},
      [&](const FeatureTask& task, const Cubic<float>& d) {
        if (fast || !isLost(d)) return true;
        leaveOpen(task, 0);
        return false;
      },
      [&](const FeatureTask& task, const FeatureVerdict& verdict) {
        if (verdict.part == PartVerdict::kMeet) addMeeting(c, task.candidate, verdict);
        if (verdict.part == PartVerdict::kOpen) leaveOpen(task, verdict.low);
      });
}

// Examines the open features of contacts.first_list in double.
__global__ void __launch_bounds__(kThreads) doubleKernel(CycleArrays c) {
  const CycleParams& params = c.params();
  const bool wants_time = params.first_times != 0;
  halveFeatures<double>(
      c, FeatureSource(c, c.contacts.first_list, sweptCounters(c).left, 0),
      {wants_time, kMostPieces}, [](const FeatureTask&, const Cubic<double>&) { return true; },
      [&](const FeatureTask& task, const FeatureVerdict& verdict) {
        SweptState& state = c.contacts.states[task.candidate];
        if (verdict.part == PartVerdict::kMeet) addMeeting(c, task.candidate, verdict);
        if (verdict.part != PartVerdict::kOpen) atomicAnd(&state.bits, ~(1U << task.index));
        if (verdict.part == PartVerdict::kOpen) {
          atomicMin(&state.open_low, __float_as_uint(verdict.low));
        }
      });
}

// One thread for each feature of contacts.first_list that double leaves open: decides those that
// integer arithmetic can.
__global__ void __launch_bounds__(kThreads) integerKernel(CycleArrays c) {
  const CycleParams& params = c.params();
  const bool wants_time = params.first_times != 0;
  if (params.predicates != Predicates::kExact) return;
  FeatureSource source(c, c.contacts.first_list, sweptCounters(c).left, 0);
  while (source.hasMore()) {
    if (warpIsCutOff(c, false)) return;
    FeatureTask task{};
    if (source.next(task) && !isDecided(c, task.candidate, wants_time)) {
      SweptState& state = c.contacts.states[task.candidate];
      const FeatureVerdict verdict = detail::integerVerdict<kAllSweptFilters>(
          featureAt(c, task), nullptr, __uint_as_float(state.open_low), wants_time);
      if (verdict.part == PartVerdict::kMeet) addMeeting(c, task.candidate, verdict);
      if (verdict.part != PartVerdict::kOpen) atomicAnd(&state.bits, ~(1U << task.index));
    }
    __syncwarp();
  }
}

// One thread for each of contacts.second_list: combines the verdicts on its features. The pair is a
// contact, is left to the host, or is listed for the test of its pad.
__global__ void __launch_bounds__(kThreads) verdictKernel(CycleArrays c) {
  const CycleParams& params = c.params();
  const bool wants_time = params.first_times != 0;
  const bool exact = params.predicates == Predicates::kExact;
  const bool cut_off = c.counters().cut_off != 0;  // some features may not have been examined
  forEachByWarp(c, sweptCounters(c).featured, [&](Place k, bool there) {
    Place i(0);
    bool meets = false, undecided = false, for_host = false;
    ContactTimes times{0, 0};
    if (there) {
      i = c.contacts.second_list[k];
      const SweptState state = c.contacts.states[i];
      const bool met = hasMet(state);
      const bool open = (state.bits & kFeatureBits) != 0 && (wants_time || !met);
      const bool at_end = (state.bits & kMeetsAtEnd) != 0;
      times = {__uint_as_float(state.low), __uint_as_float(state.high)};
      undecided = (state.bits & kUndecided) != 0;
      for_host = open && exact;
      meets = !for_host && (met || open || at_end);
      if (open) {
        undecided = true;
        times = {fminf(times.low, __uint_as_float(state.open_low)), fminf(times.high, 1)};
      } else if (!met) {
        times = {undecided ? 0.0F : 1.0F, 1};
      }
      if (cut_off && (wants_time || !met)) meets = for_host = there = false;
      if (for_host) {
        leaveToHost(c, i,
                    {PartVerdict::kOpen, __uint_as_float(state.low), __uint_as_float(state.high),
                     state.bits & kFeatureBits, at_end});
      }
    }
    __syncwarp();
    warpCount(&c.counters().undecided, meets && undecided);
    reportMoving(c, meets, i, times);
    dismiss(c, there && !meets && !for_host, i);
  });
}

}  // namespace

void launchNarrowPhaseFeatures(const CycleArrays& cycle, const CycleShape& shape,
                               cudaStream_t stream) {
  launchList(signsKernel, kThreads, cycle, shape, stream);
  launchList(featureKernel, kThreads, cycle, shape, stream);
  launchList(doubleKernel, kThreads, cycle, shape, stream);
  launchList(integerKernel, kThreads, cycle, shape, stream);
  constexpr unsigned kVerdictBlocksEach = 3;  // of a multiprocessor
  verdictKernel<<<kVerdictBlocksEach * shape.device.multiprocessors, kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
