#include <algorithm>
#include <cstring>

#include "cuda/cycle/cuda_cycles.cuh"
#include "cuda/device/cuda_error.h"
#include "cuda/device/warp.cuh"
#include "cuda/memory/pinned_pages.cuh"

namespace deformable_contact_monitor {
namespace {

// Bounds the time that a tiny memory limit can cost.
constexpr std::uint32_t kMostPasses = 4096;

}  // namespace

// Unless they are there already.
void CudaDetector::addParams() {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): what means the same may be sent again
  if (params_sent_ && std::memcmp(&sent_params_, params_.data(), sizeof sent_params_) == 0) return;
  std::memcpy(&sent_params_, params_.data(), sizeof sent_params_);
  params_sent_ = true;
  copies_.add(static_cast<const CycleParams*>(reachedAt(params_.data())), 1,
              arrays_.the_params.data());
}

// What the first kernel of a cycle finds there.
void CudaDetector::startCycle(const CycleShape& shape) {
  addParams();
  addClearing(arrays_, shape, copies_);
  copies_.launch();
}

// Where the bins have no room, or not where it is needed, part of a cycle finds out how much that
// is; where clusters are new and no frame fits yet, more of one finds those.
void CudaDetector::sizeBins(const Options& options, bool new_clusters) {
  if (arrays_.together()) return;
  const CycleShape shape = shapeOf(options, 0);
  const cudaStream_t stream = stream_.get();
  startCycle(shape);
  launchPose(arrays_, shape, stream);
  launchAssign(arrays_, shape, stream);
  launchAssignBins(arrays_, shape, stream);
  if (!new_clusters) return;
  startCycle(shape);
  launchPose(arrays_, shape, stream);
  launchAssign(arrays_, shape, stream);
  launchSort(arrays_, shape, stream);
  launchSortFrames(arrays_, shape, stream);
}

CycleShape CudaDetector::shapeOf(const Options& options, int refinements) const {
  const bool sharers = scene_.anySelf() && options.adjacent == AdjacentPairs::kBeyondShared;
  const bool swept = options.motion == Motion::kSwept;
  const bool pads = swept && scene_.anyLengths().pads;
  const bool fans = params_[0].fans != 0;
  return {device_, scene_.anySelf(),          refinements, swept, sharers, pads,
          fans,    params_[0].leaves_few != 0};
}

void CudaDetector::runCycle(const Options& options) {
  const cudaStream_t stream = stream_.get();
  const bool refresh = sizes_.clusters > 1 && ++cycles_since_refresh_ >= options.refresh_period;
  if (refresh) cycles_since_refresh_ = 0;
  const CycleShape shape = shapeOf(options, refresh ? options.iterations : 0);
  startCycle(shape);
  if (settings_.time_stages) {
    cycle_start_.record(stream);
    graphs_[0].runTimed(arrays_, shape, stream);
  } else {
    graphs_[refresh ? 1 : 0].run(arrays_, shape, cycle_start_, stream);
  }
  cycle_end_.record(stream);
}

// Runs cycles until all that one finds has room, and fetches the contacts. False if the limit was
// over before that: then they are what the last one found.
bool CudaDetector::runUntilItFits(const Options& options, const CycleLimit& limit) {
  constexpr int kMostTries = 16;
  bool all = false;
  decide_ms_ = earlier_ms_ = 0;
  all_decided_ = true;
  open_pairs_.clear();
  for (int tries = 1;; ++tries) {
    runCycle(options);
    fetchContacts(options, limit.isSet());
    checkCuda(cudaGetLastError(), "a launch");
    wait(limit);
    if (isCutOff(limit)) break;
    all = makeRoom();
    if (all) break;
    if (tries == kMostTries)
      throw CudaError(BackendFault::kTransient, "the sizes of a cycle do not settle");
    earlier_ms_ += CudaEvent::between(cycle_start_, cycle_end_);
  }
  const bool too_many =
      counters_[0].candidates > sizes_.candidates || counters_[0].open_pairs > sizes_.open_pairs;
  const bool in_passes = too_many && !limit.over();
  if (in_passes) {
    all = runInPasses(options, limit);
  } else if (all) {
    decideOpenPairs(options, limit);
  }
  if (in_passes) {
    fetchContacts(options, limit.isSet());
    wait(limit);
  }
  completeContacts(limit);
  return all && counters_[0].candidates <= sizes_.candidates;
}

// What the fetch did not bring, now that it is known how many there are.
void CudaDetector::completeContacts(const CycleLimit& limit) {
  std::uint32_t count = listable(counters_[0].contacts);
  if (limit.over()) count = std::min(count, kMostListedLate);
  if (output_.has(count)) return;
  // Page-locked memory takes its time: the limit is looked at in between.
  std::uint32_t room = limit.isSet() ? std::min(count, kMostListedLate) : count;
  output_.makeRoom(room, result_.contacts, stream_.get());
  while (room < count && !limit.over()) {
    room = std::min(count, 2 * room);
    output_.makeRoom(room, result_.contacts, stream_.get());
  }
  output_.fetchAgain(arrays_, params_[0].index_bits, room, result_.contacts, stream_.get());
  checkCuda(cudaGetLastError(), "a launch");
  wait(limit);
}

void CudaDetector::decideOpenPairs(const Options& options, const CycleLimit& limit) {
  const Stopwatch watch{};
  open_pairs_.decide(arrays_, std::min(counters_[0].open_pairs, sizes_.open_pairs), options, limit,
                     stream_.get());
  decide_ms_ += watch.elapsedMs();
  all_decided_ = all_decided_ && !limit.wasOver();
}

// Whether the last cycle gave up, or leaves work for which no time is left.
bool CudaDetector::isCutOff(const CycleLimit& limit) const {
  if (counters_[0].cut_off != 0) return true;
  return limit.over() && !(counters_[0].bin_overflow == 0 && sizes_.hold(counters_[0]));
}

// After a cycle that may have overflown: true if it fitted, else there is more room now.
bool CudaDetector::makeRoom() {
  const bool fits = counters_[0].bin_overflow == 0;
  const bool grown = sizes_.growFor(counters_[0], settings_.memory_limit_bytes);
  if (grown) makeArrays();
  return fits && !grown;
}

// As sweepInPasses(), until the contacts have room.
bool CudaDetector::runInPasses(const Options& options, const CycleLimit& limit) {
  while (sweepInPasses(options, limit) && !isCutOff(limit)) {
    if (makeRoom()) return true;
  }
  return false;
}

// More candidates than memory: judges them in several passes over the pairs of tiles and blocks.
// Those that no pass has room for are counted, not judged. False if the limit was over before the
// last.
bool CudaDetector::sweepInPasses(const Options& options, const CycleLimit& limit) {
  const cudaStream_t stream = stream_.get();
  const CycleShape shape = shapeOf(options, 0);
  const std::uint32_t most =
      std::min(kMostPasses, std::max(kWarp * (arrays_.scene.tile_count + counters_[0].tile_pairs +
                                              counters_[0].crowded_pairs),
                                     largeBlocks(arrays_)));
  const std::uint64_t found = counters_[0].judged + counters_[0].unjudged;
  auto passes =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(most, found / sizes_.candidates + 2));
  while (true) {
    bool fits = true;
    open_pairs_.clear();
    for (std::uint32_t pass = 0; pass < passes && (fits || passes == most); ++pass) {
      params_[0].pass = pass;
      params_[0].passes = passes;
      addParams();
      copies_.launch();
      launchRestart(arrays_, pass == 0, stream);
      launchPairs(arrays_, shape, stream);
      launchLarge(arrays_, shape, stream);
      launchJudge(arrays_, shape, stream);
      checkCuda(cudaGetLastError(), "a launch");
      wait(limit);
      fits = counters_[0].candidates <= sizes_.candidates &&
             counters_[0].open_pairs <= sizes_.open_pairs;
      decideOpenPairs(options, limit);
      if (counters_[0].cut_off != 0 || ((pass + 1 < passes || !fits) && limit.over())) {
        cycle_end_.record(stream);
        return false;
      }
    }
    cycle_end_.record(stream);
    if (fits || passes == most) return true;
    passes = std::min(most, 2 * passes);
  }
}

}  // namespace deformable_contact_monitor
