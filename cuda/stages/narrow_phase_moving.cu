// Stage narrow_phase in swept motion, first part: tests candidates by moving boxes and planes, by
// the static predicates at both ends of the time interval, and by fixed directions. The last part,
// for pads, is here too. narrow_phase_moving.cuh describes the lists between the kernels.
#include "core/predicates/swept_pad.h"
#include "cuda/stages/found_pairs.cuh"
#include "cuda/stages/narrow_phase_moving.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

// Returns whether moving boxes and moving planes leave a pair open. If so, `facts` gets the sides
// that the planes found.
__device__ bool planesLeave(const MovingTriangle& a, const MovingTriangle& b,
                            std::uint32_t& facts) {
  if (areApart(boxOf(a), boxOf(b))) return false;
  const MovingSides<float> sides_b(MovingPlane<float>(a), b);
  if (sides_b.areApart()) return false;
  KnownSides start, end;
  sides_b.atStart(start.b);
  sides_b.atEnd(end.b);
  const MovingSides<float> sides_a(MovingPlane<float>(b), a);
  if (sides_a.areApart()) return false;
  sides_a.atStart(start.a);
  sides_a.atEnd(end.a);
  facts = packSides(start) | packSides(end) << kEndShift;
  return true;
}

// One thread for each of contacts.candidates: adds pairs that planes leave, and pairs that share
// vertices, to contacts.open.
__global__ void __launch_bounds__(kThreads) planesKernel(CycleArrays c) {
  followPrevious();
  const std::uint32_t count = candidateCount(c);
  forEachByWarp(c, count, [&](Place i, bool there) {
    DeviceCandidate candidate{};
    bool shares = false, left = false;
    if (there) {
      candidate = c.contacts.candidates[i];
      shares = sharedBitsOf(candidate) != 0;
    }
    if (there && !shares) {
      left = planesLeave(movingAt(c, candidate.a), movingAt(c, candidate.b), candidate.facts);
    }
    if (left) c.contacts.candidates[i].facts = candidate.facts;
    reportOpen(c, left || shares, shares, i);
    dismiss(c, there && !shares && !left, i);
  });
}

// One thread for each pair that the planes left: applies the filters of the static predicates at
// both ends. A pair that meets at the start is a contact at time 0. A pair that meets at the end is
// one too, unless its time is asked for. Pairs that stay open are added to first_list.
__global__ void __launch_bounds__(kThreads) staticKernel(CycleArrays c) {
  followPrevious();
  const CycleParams& params = c.params();
  forEachByWarp(c, c.counters().open, [&](Place k, bool there) {
    Place i(0);
    bool meets = false, left = false;
    ContactTimes times{0, 0};
    if (there) {
      i = c.contacts.open[k];
      const DeviceCandidate candidate = c.contacts.candidates[i];
      const MovingTriangle a = movingAt(c, candidate.a), b = movingAt(c, candidate.b);
      const bool still = isStill(a) && isStill(b);
      const PartVerdict start = quickIntersection(a.from, b.from, unpackSides(candidate.facts));
      PartVerdict end = PartVerdict::kApart;
      meets = start == PartVerdict::kMeet;
      if (!meets && !still) {
        end = quickIntersection(a.to, b.to, unpackSides(candidate.facts >> kEndShift));
        if (end == PartVerdict::kMeet && params.first_times == 0) {
          meets = true;
          times.high = 1;
        }
      }
      left = !meets && !(still && start == PartVerdict::kApart);
      if (left) {
        c.contacts.candidates[i].facts = (candidate.facts & ~(kStartOpen | kEndOpen)) |
                                         (start == PartVerdict::kOpen ? kStartOpen : 0) |
                                         (end == PartVerdict::kOpen ? kEndOpen : 0);
        c.contacts.states[i] = {kNever, kNever, kNever,
                                end == PartVerdict::kMeet ? kMeetsAtEnd : 0};
      }
    }
    reportMoving(c, meets, i, times);
    append(c.contacts.first_list, &sweptCounters(c).moving, left, i);
    dismiss(c, there && !meets && !left, i);
  });
}

// One thread for each pair of first_list: tests fixed separating directions. What they leave goes
// to third_list if a static filter left an end open, else to second_list.
__global__ void __launch_bounds__(kThreads) directionsKernel(CycleArrays c) {
  followPrevious();
  forEachByWarp(c, sweptCounters(c).moving, [&](Place k, bool there) {
    Place i(0);
    bool apart = false, open = false;
    if (there) {
      i = c.contacts.first_list[k];
      const DeviceCandidate candidate = c.contacts.candidates[i];
      apart = (c.contacts.states[i].bits & kMeetsAtEnd) == 0 &&
              FixedDirections<float>(movingAt(c, candidate.a), movingAt(c, candidate.b)).areApart();
      open = (candidate.facts & (kStartOpen | kEndOpen)) != 0;
    }
    dismiss(c, apart, i);
    append(c.contacts.third_list, &sweptCounters(c).robust, there && !apart && open, i);
    append(c.contacts.second_list, &sweptCounters(c).featured, there && !apart && !open, i);
  });
}

// One thread for each pair of third_list: decides the ends that the static filters left open. Adds
// contacts, and pairs that are still open to second_list.
__global__ void __launch_bounds__(kThreads) robustKernel(CycleArrays c) {
  followPrevious();
  const CycleParams& params = c.params();
  forEachByWarp(c, sweptCounters(c).robust, [&](Place k, bool there) {
    Place i(0);
    bool meets = false, left = false;
    ContactTimes times{0, 0};
    PredicateState state;
    state.mode = params.predicates;
    if (there) {
      i = c.contacts.third_list[k];
      const DeviceCandidate candidate = c.contacts.candidates[i];
      const MovingTriangle a = movingAt(c, candidate.a), b = movingAt(c, candidate.b);
      const bool still = isStill(a) && isStill(b);
      // Tests the start, then the end, in a loop: so the code of the predicate exists only once.
      for (int end = 0; end < 2 && !meets; ++end) {
        if ((candidate.facts & (end == 0 ? kStartOpen : kEndOpen)) == 0) continue;
        const KnownSides sides = unpackSides(candidate.facts >> (end * kEndShift));
        if (!robustIntersection(end == 0 ? a.from : a.to, end == 0 ? b.from : b.to, sides, state)) {
          continue;
        }
        if (end == 0) {
          times.high = state.undecided ? 1 : 0;
          meets = true;
        } else if (params.first_times == 0) {
          times.high = 1;
          meets = true;
        } else {
          c.contacts.states[i].bits |= kMeetsAtEnd;
        }
      }
      left = !meets && !still;
      if (left && state.undecided) c.contacts.states[i].bits |= kUndecided;
    }
    __syncwarp();
    warpCount(&c.counters().exact, state.exact > 0);
    warpCount(&c.counters().undecided, meets && state.undecided);
    reportMoving(c, meets, i, times);
    append(c.contacts.second_list, &sweptCounters(c).featured, left, i);
    dismiss(c, there && !meets && !left, i);
  });
}

// One thread for each of contacts.dismissed: tests whether a pad makes the pair a contact. This is
// the last kernel of a cycle, so it also copies the counters to the host.
__global__ void __launch_bounds__(kThreads) padKernel(CycleArrays c) {
  followPrevious();
  const std::uint32_t count = c.params().pads == 0 ? 0 : sweptCounters(c).dismissed;
  forEachByWarp(c, count, [&](Place k, bool there) {
    Place i(0);
    PadVerdict verdict;
    if (there) {
      i = c.contacts.dismissed[k];
      const DeviceCandidate pair = c.contacts.candidates[i];
      const float pad_m = padOf(c, c.tiles.entries[pair.a], c.tiles.entries[pair.b]);
      if (pad_m > 0) verdict = withinPad(movingAt(c, pair.a), movingAt(c, pair.b), pad_m);
    }
    reportMoving(c, verdict.may_touch, i, {verdict.first_low, -1});
  });
  writeFinalCounters(c, gridDim.x);
}

}  // namespace

void launchNarrowPhaseMoving(const CycleArrays& cycle, const CycleShape& shape,
                             cudaStream_t stream) {
  // Other branches may end just before this kernel, so that it is a plain launch.
  const unsigned blocks = blocksInOneWave(planesKernel, kThreads, 0, shape.device);
  planesKernel<<<blocks, kThreads, 0, stream>>>(cycle);
  launchList(staticKernel, kThreads, cycle, shape, stream);
  launchList(directionsKernel, kThreads, cycle, shape, stream);
  launchList(robustKernel, kThreads, cycle, shape, stream);
  launchNarrowPhaseFeatures(cycle, shape, stream);
  if (shape.adjacent) launchNarrowPhaseAdjacent(cycle, shape, stream);
  if (shape.pads) {
    launchList(padKernel, kThreads, cycle, shape, stream);
  } else {
    // Only copies the counters.
    launchDependent(padKernel, 1, kThreads, 0, shape.device, stream, cycle);
  }
}

}  // namespace deformable_contact_monitor
