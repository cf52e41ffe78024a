// Stage narrow_phase in swept motion, second part: examines the features (vertex against face, edge
// against edge) of the pairs that the first part leaves. One thread works on one feature at a time:
// first in float32, then in double, then by integers. The rest is left to the host.
#include "cuda/stages/halving.cuh"
#include "cuda/stages/swept_features.cuh"

namespace deformable_contact_monitor {
namespace {

// A warp with at least so many idle lanes fetches more features.
constexpr unsigned kHungry = 20;

struct HalvingLimits {
  bool wants_time;
  int most_pieces;
  float narrow = wants_time ? 1.0F / (1 << kTimeHalvings) : 1.0F;  // as in Halving::step()
};

// Halves the features of a source (halving.cuh), except those of pairs that are decided.
// takes(task, coplanarity) may reject a feature; finish(task, verdict) gets the verdicts on the
// others. Lanes that are done wait until kHungry are idle; then all of them get new features from a
// queue, so that the code that begins features runs on many lanes at once.
template <class Real, class Takes, class Finish>
__device__ void halveFeatures(const CycleArrays& c, FeatureSource source,
                              const HalvingLimits& limits, const Takes& takes,
                              const Finish& finish) {
  __shared__ FeatureTask items[kFeatureWarps][2 * kWarp];
  const std::uint32_t warp = (blockIdx.x * kFeatureThreads + threadIdx.x) / kWarp;
  TaskQueue queue{items[threadIdx.x / kWarp], 0};
  FeatureTask task{};
  Halving<Real> halving;
  typename Halving<Real>::Kept kept;
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
            active = halving.begin(feature, d, kept);
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
    const HalvingStep step = halving.step(limits.narrow, high, limits.most_pieces, errors, kept);
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
// their cubics leave open. If roots are looked for, those whose cubic has one root are marked for
// coarseRootKernel.
__global__ void __launch_bounds__(kFeatureThreads, 4) signsKernel(CycleArrays c) {
  followPrevious();
  const bool by_roots = looksForRoots(c);
  forEachByWarp(c, sweptCounters(c).featured, [&](Place k, bool there) {
    if (!there) return;
    const Place i = c.contacts.second_list[k];
    const DeviceCandidate pair = c.contacts.candidates[i];
    const MovingTriangle a = movingAt(c, pair.a), b = movingAt(c, pair.b);
    const FeatureBoxes boxes(a, b);
    std::uint32_t left = 0, roots = 0;
#pragma unroll
    for (int f = 0; f < kFeatures; ++f) {
      if (boxes.areApart(f)) continue;
      const Cubic<float> d = coplanarity<float>(featureOf(a, b, f));
      if (d.sign() != 0) continue;
      left |= 1U << f;
      if (detail::hasOneRoot(d)) roots |= 1U << f;
    }
    if (!by_roots) roots = 0;
    c.contacts.states[i].bits |= (left & ~roots) << kLeftAt | roots;
    c.contacts.candidates[i].facts = uncertainBits(left & ~roots);
  });
}

// Examines the features that signsKernel left, in float32. Pairs with open features are added to
// first_list. If times are wanted, features only have to meet in a short interval, and are left to
// double.
__global__ void __launch_bounds__(kFeatureThreads, 4) featureKernel(CycleArrays c) {
  followPrevious();
  const CycleParams& params = c.params();
  const bool wants_time = params.first_times != 0;
  HalvingLimits limits{wants_time, 16};  // double continues
  if (wants_time) limits.narrow = 1.0F / (1 << detail::kRootHalvings<float>);
  const auto leaveOpen = [&c](const FeatureTask& task) {
    SweptState& state = c.contacts.states[task.candidate];
    const std::uint32_t before = atomicOr(&state.bits, 1U << task.index);
    if ((before & kFeatureBits) == 0) {
      c.contacts.first_list[Place(atomicAdd(&sweptCounters(c).left, 1U))] = task.candidate;
    }
  };
  halveFeatures<float>(
      c, FeatureSource(c, c.contacts.second_list, sweptCounters(c).featured, kLeftAt), limits,
      [&](const FeatureTask& task, const Cubic<float>& d) {
        if (!isLost(d)) return true;
        leaveOpen(task);
        return false;
      },
      [&](const FeatureTask& task, const FeatureVerdict& verdict) {
        const bool meets = verdict.part == PartVerdict::kMeet;
        if (meets && !wants_time) addMeeting(c, task.candidate, verdict);
        if (meets && wants_time) {
          lowerHigh(c, task.candidate, verdict.high);
          if (verdict.high - verdict.low == limits.narrow) markCertain(c, task);
        }
        if (verdict.part == PartVerdict::kOpen || (meets && wants_time)) leaveOpen(task);
      });
}

// Examines the open features of contacts.first_list in double.
__global__ void __launch_bounds__(kFeatureThreads) doubleKernel(CycleArrays c) {
  followPrevious();
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
__global__ void __launch_bounds__(kFeatureThreads) integerKernel(CycleArrays c) {
  followPrevious();
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
__global__ void __launch_bounds__(kFeatureThreads) verdictKernel(CycleArrays c) {
  followPrevious();
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
  launchList(signsKernel, kFeatureThreads, cycle, shape, stream);
  launchCoarseRoots(cycle, shape, stream);
  launchList(featureKernel, kFeatureThreads, cycle, shape, stream);
  if (shape.times) launchFineRoots(cycle, shape, stream);
  launchList(doubleKernel, kFeatureThreads, cycle, shape, stream);
  launchList(integerKernel, kFeatureThreads, cycle, shape, stream);
  constexpr unsigned kVerdictBlocksEach = 3;  // of a multiprocessor
  launchDependent(verdictKernel, kVerdictBlocksEach * shape.device.multiprocessors, kFeatureThreads,
                  0, shape.device, stream, cycle);
}

}  // namespace deformable_contact_monitor
