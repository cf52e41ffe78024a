// Implements the checker of states on one GPU. Bodies, tiles and boxes stay on the device from
// check to check. States are decided in batches, each a few launches: for each moved body in each
// state, a warp compares boxes of bodies, regions and tiles, and lists the pairs of tiles that
// matter; then a warp for each pair compares their triangles, with the predicates of the detector.
// For nearest pairs, a first kernel computes an upper bound of each state's distance from sample
// points of tiles, and searches the tiles that gave the bound, so that few others are listed.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

#include "core/bounds/pair_radii.h"
#include "core/common/cycle_limit.h"
#include "core/common/forks.h"
#include "core/common/stopwatch.h"
#include "core/states/state_input.h"
#include "cuda/cuda_state_checker.h"
#include "cuda/device/check.cuh"
#include "cuda/device/own_process.h"
#include "cuda/device/stream.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/states/state_kernels.cuh"
#include "cuda/states/state_scene.cuh"

namespace deformable_contact_monitor {
namespace {

// States in a batch. With limits they are fewer, because a batch that is stopped is lost.
constexpr std::size_t kBatch = 8192, kLimitedBatch = 512;
// How many pairs of tiles, and of triangles that are the nearest so far, have room at first.
constexpr std::size_t kNearTiles = 1 << 20, kHits = 1 << 18;

// Returns the device that checks states: of several the first one.
int deviceOf(const CudaSettings& settings) {
  return settings.devices.empty() ? settings.device : settings.devices.front();
}

class CudaStateChecker : public StateChecker {
 public:
  explicit CudaStateChecker(const CudaSettings& settings)
      : device_(deviceOf(settings)),
        limit_bytes_(settings.memory_limit_bytes),
        traits_(DeviceTraits::of(deviceOf(settings))) {}
  ~CudaStateChecker() override {
    cudaSetDevice(device_);
    cudaStreamSynchronize(stream_.get());
  }

  std::string backend() const override { return "cuda"; }
  void reset() override { scene_.forget(); }
  const StateResults& check(const Scene& scene, const StateBatch& batch,
                            const StateOptions& options) override;

 private:
  void checkAll(const Scene& scene, const StateBatch& batch, const StateOptions& options);
  std::size_t batchSize(const StateOptions& options, std::size_t pairs, std::size_t moved) const;
  void stagePoses(const StateBatch& batch, std::size_t first, std::size_t count);
  void makeRoom(std::size_t count, std::size_t moved, const StateOptions& options);
  StateArrays arraysFor(std::size_t count, const StateOptions& options, const CycleLimit& limit);
  bool run(std::size_t count, const StateOptions& options, const CycleLimit& limit);
  bool searchAgain(StateArrays* arrays, const CycleLimit& limit);
  bool wait(const CycleLimit& limit);
  void fetch(std::size_t count, const StateOptions& options);
  bool answer(const Scene& scene, std::size_t first, std::size_t count, bool all,
              const StateOptions& options);
  NearestPair nearestOf(const Scene& scene, const StateNearest& found) const;

  const int device_;
  const std::uint64_t limit_bytes_;
  const DeviceTraits traits_;
  CudaStream stream_;
  StateScene scene_;
  StateResults results_;

  std::vector<std::uint8_t> is_finite_;  // by state of the batch: all of its poses are
  PinnedBuffer<RigidTransform> staged_poses_;
  PinnedBuffer<std::uint32_t> stop_{1};
  PinnedBuffer<StateCounters> counted_{1};
  PinnedBuffer<std::uint32_t> touches_, leaves_;
  PinnedBuffer<std::uint8_t> pair_touches_;
  PinnedBuffer<StateNearest> found_;

  DeviceBuffer<RigidTransform> d_poses_;
  DeviceBuffer<StateTiles> d_near_tiles_;
  DeviceBuffer<StateHit> d_hits_;
  DeviceBuffer<std::uint32_t> d_touches_, d_leaves_, d_apart_, d_best_pair_, d_best_b_;
  DeviceBuffer<unsigned long long> d_best_a_, d_first_touch_, d_seed_key_;
  DeviceBuffer<StateTiles> d_seeds_;
  DeviceBuffer<std::uint8_t> d_pair_touches_;
  DeviceBuffer<StateNearest> d_found_;
  DeviceBuffer<StateCounters> d_counters_;
};

const StateResults& CudaStateChecker::check(const Scene& scene, const StateBatch& batch,
                                            const StateOptions& options) {
  const Stopwatch watch;
  requireValid(scene, batch);
  results_.states.assign(batch.count, StateAnswer());
  results_.pairs.clear();
  results_.rejected.clear();
  results_.cut_off = false;
  results_.cut_off_because.clear();
  checkCuda(cudaSetDevice(device_), "cudaSetDevice");
  cudaGetLastError();  // clears an error that this thread has from another device
  try {
    checkAll(scene, batch, options);
  } catch (...) {
    // Copies from this scene may be under way, and the caller may change it.
    cudaStreamSynchronize(stream_.get());
    scene_.forget();
    throw;
  }
  results_.check_ms = watch.elapsedMs();
  return results_;
}

void CudaStateChecker::checkAll(const Scene& scene, const StateBatch& batch,
                                const StateOptions& options) {
  const CycleLimit limit(options.limits);
  if (!scene_.update(scene, pairsOfStates(scene, batch), batch, options.limits, device_,
                     stream_.get())) {
    results_.cut_off = limit.over() && batch.count > 0;
    results_.cut_off_because = results_.cut_off ? limit.why() : "";
    return;
  }
  results_.rejected = scene_.rejected();
  std::size_t each = batchSize(options, scene_.pairs().size(), batch.moved.size());
  for (std::size_t first = 0; first < batch.count;) {
    if (limit.over()) {
      results_.cut_off = true;
      break;
    }
    const std::size_t count = std::min(each, batch.count - first);
    stagePoses(batch, first, count);
    makeRoom(count, batch.moved.size(), options);
    bool all = true;
    try {
      all = run(count, options, limit);
    } catch (const CudaError& error) {
      if (error.fault() != BackendFault::kSceneTooLarge || count == 1) throw;
      each = count / 2;  // fewer states have fewer hits
      continue;
    }
    const bool is_open = answer(scene, first, count, all, options);
    first += count;
    results_.cut_off = is_open || (!all && first < batch.count);
    if (!all) break;
  }
  if (results_.cut_off) results_.cut_off_because = limit.why();
}

// Returns how many states are decided at once. The number of a thread, of which there are 32 for
// each moved body in each state, must have room in 32 bits.
std::size_t CudaStateChecker::batchSize(const StateOptions& options, std::size_t pairs,
                                        std::size_t moved) const {
  constexpr std::size_t kMostFlags = std::size_t{1} << 28;  // of states and pairs
  constexpr std::size_t kMostWarps = std::size_t{1} << 26;
  std::size_t most = options.limits.any() ? kLimitedBatch : kBatch;
  most = std::min(most, kMostFlags / std::max<std::size_t>(1, pairs));
  return std::max<std::size_t>(1, std::min(most, kMostWarps / std::max<std::size_t>(1, moved)));
}

// Copies the poses to page-locked memory. States with poses that are not finite get other ones.
void CudaStateChecker::stagePoses(const StateBatch& batch, std::size_t first, std::size_t count) {
  const std::size_t moved = batch.moved.size();
  staged_poses_.grow(std::max<std::size_t>(1, count * moved));
  is_finite_.assign(count, 1);
  if (moved == 0) return;
  const RigidTransform* const from = batch.poses + first * moved;
  std::memcpy(staged_poses_.data(), from, count * moved * sizeof(RigidTransform));
  for (std::size_t state = 0; state < count; ++state) {
    RigidTransform* const poses = staged_poses_.data() + state * moved;
    if (std::all_of(poses, poses + moved, [](const RigidTransform& p) { return isFinite(p); })) {
      continue;
    }
    is_finite_[state] = 0;
    std::fill(poses, poses + moved, RigidTransform());
  }
}

void CudaStateChecker::makeRoom(std::size_t count, std::size_t moved, const StateOptions& options) {
  const cudaStream_t stream = stream_.get();
  const std::size_t flags = std::max<std::size_t>(1, count * scene_.pairs().size());
  d_poses_.grow(std::max<std::size_t>(1, count * moved), stream);
  d_near_tiles_.grow(kNearTiles, stream);
  d_counters_.grow(1, stream);
  d_pair_touches_.grow(flags, stream);
  pair_touches_.grow(flags);
  for (DeviceBuffer<std::uint32_t>* const buffer :
       {&d_touches_, &d_leaves_, &d_apart_, &d_best_pair_, &d_best_b_}) {
    buffer->grow(count, stream);
  }
  touches_.grow(count);
  leaves_.grow(count);
  d_best_a_.grow(count, stream);
  d_first_touch_.grow(count, stream);
  d_seed_key_.grow(count, stream);
  d_seeds_.grow(std::max<std::size_t>(1, count * moved), stream);
  d_found_.grow(count, stream);
  found_.grow(count);
  if (options.nearest) d_hits_.grow(kHits, stream);
}

StateArrays CudaStateChecker::arraysFor(std::size_t count, const StateOptions& options,
                                        const CycleLimit& limit) {
  StateArrays arrays{};
  scene_.addTo(&arrays);
  arrays.state_count = static_cast<std::uint32_t>(count);
  arrays.question = {options.nearest ? 1U : 0U, options.pairs ? 1U : 0U, limit.isSet() ? 1U : 0U};
  arrays.poses = d_poses_.data();
  arrays.near_tiles = d_near_tiles_.data();
  arrays.near_tiles_size = static_cast<std::uint32_t>(d_near_tiles_.size());
  arrays.hits = d_hits_.data();
  arrays.hits_size = static_cast<std::uint32_t>(d_hits_.size());
  arrays.touches = d_touches_.data();
  arrays.leaves_floats = d_leaves_.data();
  arrays.pair_touches = d_pair_touches_.data();
  arrays.apart = d_apart_.data();
  arrays.best_pair = d_best_pair_.data();
  arrays.best_a = d_best_a_.data();
  arrays.first_touch = d_first_touch_.data();
  arrays.seed_key = d_seed_key_.data();
  arrays.seeds = d_seeds_.data();
  arrays.best_b = d_best_b_.data();
  arrays.found = d_found_.data();
  arrays.counters = d_counters_.data();
  arrays.host_stop = stop_.data();
  return arrays;
}

// Decides the staged states. Returns false if the limit stopped it.
bool CudaStateChecker::run(std::size_t count, const StateOptions& options,
                           const CycleLimit& limit) {
  const cudaStream_t stream = stream_.get();
  stop_[0] = 0;
  StateArrays arrays = arraysFor(count, options, limit);
  d_poses_.upload(staged_poses_.data(), count * arrays.moved_count, stream);
  launchStateStart(arrays, stream);
  if (arrays.pair_count > 0 && arrays.tile_count > 0) {
    launchStateLeaves(arrays, stream);
    const bool all_count = arrays.slot_part == nullptr && arrays.slot_margin == nullptr;
    if (options.nearest && all_count) launchStateBounds(arrays, stream);
    launchStateTiles(arrays, false, stream);
    launchStateTriangles(arrays, traits_, stream);
    if (options.nearest) launchStateNearest(arrays, traits_, stream);
  }
  fetch(count, options);
  if (!wait(limit)) return false;
  while (counted_[0].near_tiles > arrays.near_tiles_size ||
         (options.nearest && counted_[0].hits > arrays.hits_size)) {
    if (!searchAgain(&arrays, limit)) return false;
    fetch(count, options);
    if (!wait(limit)) return false;
  }
  return true;
}

// Repeats the search with more room. What was found so far makes it shorter. Returns false if the
// limit is over. Throws CudaError (kSceneTooLarge) if there is no more room.
bool CudaStateChecker::searchAgain(StateArrays* arrays, const CycleLimit& limit) {
  if (limit.over()) return false;
  const cudaStream_t stream = stream_.get();
  const StateCounters counted = counted_[0];
  const bool lists_tiles = counted.near_tiles <= arrays->near_tiles_size;
  if (counted.hits > arrays->hits_size) {
    const std::uint64_t wanted = std::uint64_t{counted.hits} + counted.hits / 4;
    if (counted.hits >= kMostCounted || wanted * sizeof(StateHit) > limit_bytes_) {
      throw CudaError(BackendFault::kSceneTooLarge,
                      "too many triangles of a state are equally near to be compared on CUDA");
    }
    d_hits_.grow(wanted, stream);
    arrays->hits = d_hits_.data();
    arrays->hits_size = static_cast<std::uint32_t>(d_hits_.size());
  }
  launchStateRestart(*arrays, stream);
  launchStateTiles(*arrays, !lists_tiles, stream);
  if (lists_tiles) launchStateTriangles(*arrays, traits_, stream);
  if (arrays->question.nearest != 0) launchStateNearest(*arrays, traits_, stream);
  return true;
}

// Enqueues copies of what was found to the host.
void CudaStateChecker::fetch(std::size_t count, const StateOptions& options) {
  const cudaStream_t stream = stream_.get();
  d_counters_.download(counted_.data(), 1, stream);
  d_touches_.download(touches_.data(), count, stream);
  d_leaves_.download(leaves_.data(), count, stream);
  if (options.pairs) {
    d_pair_touches_.download(pair_touches_.data(), count * scene_.pairs().size(), stream);
  }
  if (options.nearest) d_found_.download(found_.data(), count, stream);
}

// Waits for the stream. Returns false if the limit was over before: then the kernels were told to
// stop.
bool CudaStateChecker::wait(const CycleLimit& limit) {
  while (limit.isSet() && !stream_.isIdle()) {
    if (limit.over()) stop_[0] = 1;
    std::this_thread::sleep_for(std::chrono::microseconds(20));
  }
  stream_.synchronise();
  return counted_[0].stopped == 0;
}

// Writes the answers to states. `all`: the batch was not stopped. Returns whether some state is
// open because it was.
bool CudaStateChecker::answer(const Scene& scene, std::size_t first, std::size_t count, bool all,
                              const StateOptions& options) {
  const std::vector<StateScene::IdPair>& pairs = scene_.pairs();
  bool is_open = false;
  for (std::size_t i = 0; i < count; ++i) {
    StateAnswer& answer = results_.states[first + i];
    const bool touches = touches_[i] != 0;
    const bool is_whole = all || (touches && !options.nearest && !options.pairs);
    is_open = is_open || !is_whole;
    if (is_finite_[i] == 0 || !is_whole) continue;
    const bool found = options.nearest && found_[i].pair != kNone;
    if (touches) {
      answer.decision = PairDecision::kContact;
    } else if (leaves_[i] == 0 && !scene_.leavesFloats()) {
      answer.decision = found ? PairDecision::kNear : PairDecision::kNone;
    }
    if (found && answer.decision != PairDecision::kOpen) {
      answer.nearest = nearestOf(scene, found_[i]);
    }
    if (!touches || !options.pairs) continue;
    const std::uint8_t* const touching = pair_touches_.data() + i * pairs.size();
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      if (touching[p] == 0) continue;
      results_.pairs.push_back(
          {static_cast<std::uint32_t>(first + i), pairs[p].first, pairs[p].second});
    }
  }
  return is_open;
}

NearestPair CudaStateChecker::nearestOf(const Scene& scene, const StateNearest& found) const {
  const auto& [a, b] = scene_.pairs()[found.pair];
  NearestPair nearest;
  nearest.pair = {a, scene_.triangleOf(found.slot_a), b, scene_.triangleOf(found.slot_b)};
  nearest.distance_m = found.bare_m;
  nearest.point_a = found.point_a;
  nearest.point_b = found.point_b;
  nearest.normal = found.normal;
  deflate(PairRadii(scene.body(a), scene.body(b)), &nearest);
  return nearest;
}

// Keeps the checker out of processes that are forked after it was made. There its destructor could
// wait for ever, so it stays as it is.
class OwnProcessChecker : public StateChecker {
 public:
  explicit OwnProcessChecker(std::unique_ptr<StateChecker> checker) : checker_(std::move(checker)) {
    made_.set();
  }
  ~OwnProcessChecker() override {
    if (made_.isInherited()) static_cast<void>(checker_.release());
  }
  std::string backend() const override { return "cuda"; }
  void reset() override {
    if (!made_.isInherited()) checker_->reset();
  }
  const StateResults& check(const Scene& scene, const StateBatch& batch,
                            const StateOptions& options) override {
    requireOwnProcess();
    return checker_->check(scene, batch, options);
  }

 private:
  std::unique_ptr<StateChecker> checker_;
  ProcessMark made_;
};

}  // namespace

std::unique_ptr<StateChecker> makeCudaStateChecker(const CudaSettings& settings) {
  requireOwnProcess();
  requireUsable(deviceOf(settings));
  noteDeviceUse();
  return std::make_unique<OwnProcessChecker>(std::make_unique<CudaStateChecker>(settings));
}

}  // namespace deformable_contact_monitor
