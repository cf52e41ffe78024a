// Stage judge in swept motion, second part: the features of what is left, a thread each: in
// float32, then in double, then by integers; the rest is the host's.
#include "cuda/stages/judge_moving.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;
constexpr unsigned kWarps = kThreads / kWarp;
constexpr unsigned kLanesEach = 16;  // of a pair

// One feature of a candidate.
struct FeatureTask {
  Place candidate;
  std::uint32_t index;  // as featureOf has them
};

// Of one warp, in shared memory; `size` is the same in all lanes.
struct TaskQueue {
  FeatureTask* items;
  unsigned size;

  __device__ void push(bool has, const FeatureTask& task) {
    const unsigned mask = __ballot_sync(kFullWarp, has);
    if (has) items[size + __popc(mask & ((1U << laneId()) - 1))] = task;
    size += __popc(mask);
    __syncwarp();
  }
  __device__ bool pop(FeatureTask& task) {
    const unsigned taken = min(size, kWarp);
    size -= taken;
    const bool got = laneId() < taken;
    if (got) task = items[size + laneId()];
    __syncwarp();
    return got;
  }
};

__device__ MovingPoint pointAt(const CycleArrays& c, MemberIndex at, int i) {
  return {c.members.earlier[at].posed.v[i], c.members.members[at].posed.v[i]};
}

// As featureOf, without the triangles in registers: they would be indexed by numbers that the
// compiler does not know.
__device__ Feature featureAt(const CycleArrays& c, const FeatureTask& task) {
  const DeviceCandidate pair = c.contacts.candidates[task.candidate];
  const int index = static_cast<int>(task.index);
  if (index < 6) {
    const MemberIndex face = index < 3 ? pair.a : pair.b, other = index < 3 ? pair.b : pair.a;
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

// What others may change meanwhile.
__device__ float highOf(const CycleArrays& c, Place candidate) {
  const volatile std::uint32_t& high = c.contacts.states[candidate].high;
  return __uint_as_float(high);
}

__device__ void addMeeting(const CycleArrays& c, Place candidate, const FeatureVerdict& verdict) {
  SweptState& state = c.contacts.states[candidate];
  atomicMin(&state.low, __float_as_uint(verdict.low));
  atomicMin(&state.high, __float_as_uint(verdict.high));
}

// Goes through a list of pairs, two a warp at a time: wants(task) chooses features, and decide(task)
// has full warps of them, but for the last.
template <class Wants, class Decide>
__device__ void forEachFeature(const CycleArrays& c, const DeviceArray<Place, Place>& list,
                               std::uint32_t count, const Wants& wants, const Decide& decide) {
  __shared__ FeatureTask items[kWarps][2 * kWarp];
  TaskQueue queue{items[threadIdx.x / kWarp], 0};
  constexpr std::uint32_t kPairs = kWarp / kLanesEach;
  const std::uint32_t warps = gridDim.x * kWarps;
  const std::uint32_t warp = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  std::uint32_t first = warp * kPairs;
  bool more = first < count;
  while (more || queue.size > 0) {
    if (queue.size >= kWarp || !more) {
      FeatureTask task{};
      const bool got = queue.pop(task);
      if (got) decide(task);
      __syncwarp();
      if (warpIsCutOff(c, warp % kWarpsPerAsker == 0)) return;
      continue;
    }
    const std::uint32_t k = first + laneId() / kLanesEach;
    FeatureTask task{Place(0), laneId() % kLanesEach};
    bool wanted = k < count && task.index < kFeatures;
    if (wanted) {
      task.candidate = list[Place(k)];
      wanted = wants(task);
    }
    queue.push(wanted, task);
    first += warps * kPairs;
    more = first < count;
  }
}

// The features of contacts.second_list, in float32; pairs with open ones come to first_list.
__global__ void __launch_bounds__(kThreads) featureKernel(CycleArrays c) {
  const CycleParams& params = c.params();
  const bool wants_time = params.first_times != 0;
  const bool fast = params.predicates == Predicates::kFast;
  forEachFeature(
      c, c.contacts.second_list, sweptCounters(c).featured,
      [&](const FeatureTask& task) {
        const Feature feature = featureAt(c, task);
        return !areApart(feature) && coplanarity<float>(feature).sign() == 0;
      },
      [&](const FeatureTask& task) {
        const float until = highOf(c, task.candidate);
        if (!wants_time && until <= 1) return;
        const Feature feature = featureAt(c, task);
        const FeatureVerdict verdict =
            halvedVerdict(feature, coplanarity<float>(feature), wants_time, until);
        if (verdict.part == PartVerdict::kMeet) addMeeting(c, task.candidate, verdict);
        if (verdict.part != PartVerdict::kOpen) return;
        SweptState& state = c.contacts.states[task.candidate];
        const std::uint32_t before = atomicOr(&state.bits, 1U << task.index);
        if (fast) {
          atomicMin(&state.open_low, __float_as_uint(verdict.low));
        } else if ((before & kFeatureBits) == 0) {
          c.contacts.first_list[Place(atomicAdd(&sweptCounters(c).left, 1U))] = task.candidate;
        }
      });
}

// The open features of contacts.first_list: in double, then by integers.
__global__ void __launch_bounds__(kThreads) doubleKernel(CycleArrays c) {
  const CycleParams& params = c.params();
  const bool wants_time = params.first_times != 0;
  const bool exact = params.predicates == Predicates::kExact;
  forEachFeature(
      c, c.contacts.first_list, sweptCounters(c).left,
      [&](const FeatureTask& task) {
        return (c.contacts.states[task.candidate].bits >> task.index & 1) != 0;
      },
      [&](const FeatureTask& task) {
        const float until = highOf(c, task.candidate);
        if (!wants_time && until <= 1) return;
        const Feature feature = featureAt(c, task);
        const FeatureVerdict verdict =
            halvedVerdict(feature, coplanarity<double>(feature), wants_time, until);
        SweptState& state = c.contacts.states[task.candidate];
        if (verdict.part == PartVerdict::kMeet) addMeeting(c, task.candidate, verdict);
        const bool open =
            verdict.part == PartVerdict::kOpen &&
            !(exact && integerSigns(feature) == IntegerSigns::kNoRootWithin);
        if (!open) atomicAnd(&state.bits, ~(1U << task.index));
        if (open && !exact) atomicMin(&state.open_low, __float_as_uint(verdict.low));
      });
}

// A thread for each of contacts.second_list: what its features told.
__global__ void __launch_bounds__(kThreads) verdictKernel(CycleArrays c) {
  const CycleParams& params = c.params();
  const bool wants_time = params.first_times != 0;
  const bool exact = params.predicates == Predicates::kExact;
  const bool cut_off = c.counters().cut_off != 0;  // some features may not have had their turn
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

void launchFeatures(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  launchList(featureKernel, kThreads, cycle, shape, stream);
  launchList(doubleKernel, kThreads, cycle, shape, stream);
  launchList(verdictKernel, kThreads, cycle, shape, stream);
}

}  // namespace deformable_contact_monitor
