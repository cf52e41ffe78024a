// Stage judge in swept motion, first part: what boxes, planes, the static predicates at both ends
// and fixed directions settle; last part: pads.
#include "core/predicates/swept_pad.h"
#include "cuda/stages/leave_counters.cuh"
#include "cuda/stages/narrow_phase_moving.cuh"
#include "cuda/stages/report.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

// Moving boxes, then moving planes. Those left keep the sides that the planes told.
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

// A thread for each of contacts.candidates.
__global__ void __launch_bounds__(kThreads) planesKernel(CycleArrays c) {
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

// A thread for each that the planes left: the static predicates' filters at both ends.
__global__ void __launch_bounds__(kThreads) staticKernel(CycleArrays c) {
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
      const PartVerdict start =
          quickIntersection(a.from, b.from, unpackSides(candidate.facts), params.predicates);
      PartVerdict end = PartVerdict::kApart;
      meets = start == PartVerdict::kMeet;
      if (!meets && !still) {
        end = quickIntersection(a.to, b.to, unpackSides(candidate.facts >> kEndShift),
                                params.predicates);
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

// A thread for each that they left: fixed directions.
__global__ void __launch_bounds__(kThreads) directionsKernel(CycleArrays c) {
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

// A thread for each whose static filters left something open.
__global__ void __launch_bounds__(kThreads) robustKernel(CycleArrays c) {
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
      // Once for the start, then for the end: one place in the code.
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

// A thread for each of contacts.dismissed: whether a pad may make it a contact. The last kernel of
// a cycle.
__global__ void __launch_bounds__(kThreads) padKernel(CycleArrays c) {
  const std::uint32_t count = c.params().pads == 0 ? 0 : sweptCounters(c).dismissed;
  forEachByWarp(c, count, [&](Place k, bool there) {
    Place i(0);
    PadVerdict verdict;
    if (there) {
      i = c.contacts.dismissed[k];
      const DeviceCandidate pair = c.contacts.candidates[i];
      const float pad_m = padOf(c, c.members.members[pair.a], c.members.members[pair.b]);
      if (pad_m > 0) verdict = withinPad(movingAt(c, pair.a), movingAt(c, pair.b), pad_m);
    }
    reportMoving(c, verdict.may_touch, i, {verdict.first_low, -1});
  });
  leaveCounters(c, gridDim.x);
}

}  // namespace

void launchJudgeMoving(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  launchList(planesKernel, kThreads, cycle, shape, stream);
  launchList(staticKernel, kThreads, cycle, shape, stream);
  launchList(directionsKernel, kThreads, cycle, shape, stream);
  launchList(robustKernel, kThreads, cycle, shape, stream);
  launchFeatures(cycle, shape, stream);
  if (shape.sharers) launchSharers(cycle, shape, stream);
  if (shape.pads) {
    launchList(padKernel, kThreads, cycle, shape, stream);
  } else {
    padKernel<<<1, kThreads, 0, stream>>>(cycle);  // leaves the counters alone
  }
}

}  // namespace deformable_contact_monitor
