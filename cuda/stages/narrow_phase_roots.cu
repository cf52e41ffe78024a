// Stage narrow_phase in swept motion: looks at once at the only root of a feature's cubic, where
// halving takes a step for each digit of the time. Float32 finds short intervals in which features
// meet. If times are wanted, double finds the first times in them. Features of one kind are
// gathered, so that the lanes of a warp do the same.
#include "core/predicates/swept_roots.h"
#include "cuda/stages/swept_features.cuh"

namespace deformable_contact_monitor {
namespace {

// Calls visit(task, whether there is one) for all features of a source, until the cycle is cut off:
// by whole warps, on as many lanes as possible, and for features of one kind at a time.
template <class Visit>
__device__ void forEachFeature(const CycleArrays& c, FeatureSource source, bool wants_time,
                               const Visit& visit) {
  __shared__ FeatureTask items[2][kFeatureWarps][2 * kWarp];
  TaskQueue faces{items[0][threadIdx.x / kWarp], 0}, edges{items[1][threadIdx.x / kWarp], 0};
  const std::uint32_t warp = (blockIdx.x * kFeatureThreads + threadIdx.x) / kWarp;
  for (std::uint32_t turn = 1;; ++turn) {
    while (faces.size < kWarp && edges.size < kWarp && source.hasMore()) {
      FeatureTask found{};
      const bool has = source.next(found) && !isDecided(c, found.candidate, wants_time);
      faces.push(has && isVertexFace(found), found);
      edges.push(has && !isVertexFace(found), found);
    }
    if (faces.size == 0 && edges.size == 0) return;
    FeatureTask task{};
    const bool there = edges.size >= faces.size ? edges.pop(true, task) : faces.pop(true, task);
    visit(task, there);
    if (turn % 8 == 0 && warpIsCutOff(c, warp % kWarpsPerAsker == 0)) return;
  }
}

// Examines the features of contacts.second_list that have one root, in float32. If times are
// wanted, those that are certain to meet are left to double, if they may do so first. So are those
// that stay open. Their pairs are added to first_list.
__global__ void __launch_bounds__(kFeatureThreads) coarseRootKernel(CycleArrays c) {
  followPrevious();
  if (!looksForRoots(c)) return;
  const FeatureSource source(c, c.contacts.second_list, sweptCounters(c).featured, 0, true);
  const bool wants_time = c.params().first_times != 0;
  forEachFeature(c, source, wants_time, [&c, wants_time](const FeatureTask& task, bool there) {
    FeatureVerdict verdict;
    if (there) {
      const Feature feature = featureAt(c, task);
      verdict = detail::verdictByRoot(feature, coplanarity<float>(feature), {});
    }
    const bool open = verdict.part == PartVerdict::kOpen;
    const bool meets = verdict.part == PartVerdict::kMeet;
    const bool first = meets && wants_time && verdict.low <= highOf(c, task.candidate);
    if (meets && !wants_time) addMeeting(c, task.candidate, verdict);
    if (first) lowerHigh(c, task.candidate, verdict.high);
    if (open) markUncertain(c, task);
    leaveFeature(c, task, first || open);
  });
}

// Decides a feature in double. If float32 is certain when it meets at the earliest, only the
// interval of the pair's first meeting matters, which ends at `high` or shortly after.
__device__ FeatureVerdict fineVerdict(const Feature& feature, bool certain, float high) {
  constexpr int kLevel = detail::kRootHalvings<float>, kParts = 1 << kLevel;
  detail::HalvedInterval interval;
  if (certain && high <= 1) {
    interval.level = kLevel;
    interval.path = static_cast<std::uint32_t>(ceilf(high * kParts)) - 1;
  }
  const Cubic<double> d = coplanarity<double>(feature);
  return d.sign() != 0 ? FeatureVerdict{} : detail::verdictByRoot(feature, d, interval);
}

// Examines the open features of contacts.first_list in double. Those that stay open are halved.
__global__ void __launch_bounds__(kFeatureThreads) fineRootKernel(CycleArrays c) {
  followPrevious();
  const FeatureSource source(c, c.contacts.first_list, sweptCounters(c).left, 0, true);
  forEachFeature(c, source, true, [&c](const FeatureTask& task, bool there) {
    if (!there) return;
    const bool certain = !isUncertain(c, task);
    const FeatureVerdict verdict =
        fineVerdict(featureAt(c, task), certain, highOf(c, task.candidate));
    if (verdict.part == PartVerdict::kMeet) addMeeting(c, task.candidate, verdict);
    if (verdict.part == PartVerdict::kOpen) {
      atomicOr(&c.contacts.states[task.candidate].bits, 1U << task.index);
    }
  });
}

}  // namespace

void launchCoarseRoots(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  launchList(coarseRootKernel, kFeatureThreads, cycle, shape, stream);
}

void launchFineRoots(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  launchList(fineRootKernel, kFeatureThreads, cycle, shape, stream);
}

}  // namespace deformable_contact_monitor
