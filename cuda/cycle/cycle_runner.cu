// Repeats a cycle until its arrays are large enough. The device counts what it finds even where
// there is no room, so one failed try tells how much room is needed. If the memory limit does not
// allow that much, the last cycle is continued in passes over parts of the pairs.
#include <algorithm>

#include "cuda/cycle/cycle_runner.cuh"
#include "cuda/device/cuda_error.h"
#include "cuda/device/warp.cuh"

namespace deformable_contact_monitor {
namespace {

// The most passes of a cycle. It bounds the time that a very low memory limit can cost.
constexpr std::uint32_t kMostPasses = 4096;

}  // namespace

bool CycleRunner::run(const Options& options, const CycleLimit& limit) {
  constexpr int kMostTries = 16;
  bool all = false;
  earlier_ms_ = 0;
  collector_.begin();
  for (int tries = 1;; ++tries) {
    runOnce(options);
    collector_.fetch(options, limit);
    checkCuda(cudaGetLastError(), "a launch");
    cycle_.wait(limit);
    if (isCutOff(limit)) break;
    all = makeRoom();
    if (all) break;
    if (tries == kMostTries)
      throw CudaError(BackendFault::kTransient, "the sizes of a cycle do not settle");
    earlier_ms_ += CudaEvent::between(cycle_start_, cycle_end_);
  }
  const CycleCounters& counted = cycle_.counted();
  const bool too_many =
      counted.candidates > cycle_.sizes.candidates || counted.open_pairs > cycle_.sizes.open_pairs;
  if (too_many) all = false;
  if (too_many && !limit.over()) {
    all = runInPasses(options, limit);
    collector_.fetch(options, limit);
    cycle_.wait(limit);
  } else if (all) {
    collector_.decideOpenPairs(options, limit);
  }
  collector_.complete(limit);
  return all && counted.candidates <= cycle_.sizes.candidates;
}

// Enqueues one cycle. Every refresh_period cycles it also refines the prototypes, which is another
// graph.
void CycleRunner::runOnce(const Options& options) {
  const cudaStream_t stream = cycle_.stream.get();
  const bool refresh =
      cycle_.sizes.clusters > 1 && ++cycle_.cycles_since_refresh >= options.refresh_period;
  if (refresh) cycle_.cycles_since_refresh = 0;
  const CycleShape shape = cycle_.shapeOf(options, refresh ? options.iterations : 0);
  cycle_.start(shape);
  if (cycle_.settings.time_stages) {
    cycle_start_.record(stream);
    graphs_[0].runTimed(cycle_.arrays, shape, stream);
  } else {
    graphs_[refresh ? 1 : 0].run(cycle_.arrays, shape, cycle_start_, stream);
  }
  cycle_end_.record(stream);
}

// Returns whether the last cycle was stopped by the limit, or does not fit and has no time for
// another try.
bool CycleRunner::isCutOff(const CycleLimit& limit) const {
  const CycleCounters& counted = cycle_.counted();
  if (counted.cut_off != 0) return true;
  return limit.over() && !(counted.bin_overflow == 0 && cycle_.sizes.hold(counted));
}

// Returns whether all that the last cycle found had room. Grows the arrays if it had not.
bool CycleRunner::makeRoom() {
  const bool fits = cycle_.counted().bin_overflow == 0;
  const bool grown = cycle_.sizes.growFor(cycle_.counted(), cycle_.settings.memory_limit_bytes);
  if (grown) cycle_.growArrays();
  return fits && !grown;
}

// Repeats sweepInPasses() until all contacts have room. Returns false if the limit was over before.
bool CycleRunner::runInPasses(const Options& options, const CycleLimit& limit) {
  while (sweepInPasses(options, limit) && !isCutOff(limit)) {
    if (makeRoom()) return true;
  }
  return false;
}

// Examines more candidates than memory holds, in several passes over the pairs of tiles and the
// blocks of the oversized stage. If a pass finds more candidates than there is room for, it starts
// over with twice as many passes. With the greatest number of passes, candidates without room are
// only counted. Returns false if the limit was over before the last pass ended.
bool CycleRunner::sweepInPasses(const Options& options, const CycleLimit& limit) {
  const cudaStream_t stream = cycle_.stream.get();
  const CycleCounters& counted = cycle_.counted();
  const CycleShape shape = cycle_.shapeOf(options, 0);
  const std::uint64_t tile_pairs = std::uint64_t{counted.tile_pairs} + counted.dense_pairs;
  const auto most = static_cast<std::uint32_t>(std::min<std::uint64_t>(
      kMostPasses, std::max<std::uint64_t>(kWarp * (cycle_.arrays.scene.tile_count + tile_pairs),
                                           oversizedBlocks(cycle_.arrays))));
  const std::uint64_t found = counted.examined + counted.unexamined;
  auto passes = static_cast<std::uint32_t>(
      std::min<std::uint64_t>(most, found / cycle_.sizes.candidates + 2));
  while (true) {
    bool fits = true;
    collector_.dropOpenPairs();
    for (std::uint32_t pass = 0; pass < passes && (fits || passes == most); ++pass) {
      fits = runPass(shape, pass, passes, limit);
      collector_.decideOpenPairs(options, limit);
      if (counted.cut_off != 0 || ((pass + 1 < passes || !fits) && limit.over())) {
        cycle_end_.record(stream);
        return false;
      }
    }
    cycle_end_.record(stream);
    if (fits || passes == most) return true;
    passes = std::min(most, 2 * passes);
  }
}

// Runs pass number `pass` of `passes` and waits for it. Returns whether its candidates had room.
// The tiles and their pairs stay as the cycle left them.
bool CycleRunner::runPass(const CycleShape& shape, std::uint32_t pass, std::uint32_t passes,
                          const CycleLimit& limit) {
  const cudaStream_t stream = cycle_.stream.get();
  const CycleArrays& arrays = cycle_.arrays;
  cycle_.params[0].pass = pass;
  cycle_.params[0].passes = passes;
  cycle_.addParams();
  cycle_.copies.launch();
  launchRestart(arrays, pass == 0, stream);
  launchSweepTriangles(arrays, shape, stream);
  launchOversized(arrays, shape, stream);
  launchNarrowPhase(arrays, shape, stream);
  checkCuda(cudaGetLastError(), "a launch");
  cycle_.wait(limit);
  return cycle_.counted().candidates <= cycle_.sizes.candidates &&
         cycle_.counted().open_pairs <= cycle_.sizes.open_pairs;
}

}  // namespace deformable_contact_monitor
