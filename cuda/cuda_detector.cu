// Implements the detector on one GPU: uploads a scene, runs the stages, and collects the contacts.
#include <algorithm>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "core/bounds/exact_distances.h"
#include "core/common/cycle_limit.h"
#include "core/common/stopwatch.h"
#include "cuda/cuda_detector.h"
#include "cuda/cycle/contact_collector.cuh"
#include "cuda/cycle/cycle_runner.cuh"
#include "cuda/cycle/cycle_upload.cuh"
#include "cuda/cycle/device_cycle.cuh"
#include "cuda/device/check.cuh"
#include "cuda/memory/pinned_memory.cuh"
#include "cuda/memory/process_memory.h"
#include "cuda/partitions/partitioned_detector.h"

namespace deformable_contact_monitor {
namespace {

// Returns a number that is equal for options whose cycles run the same kernels.
unsigned kernelsOf(const Options& options) {
  const bool swept = options.motion == Motion::kSwept;
  return (swept ? 1U : 0U) | (searchesNearest(options) ? 2U : 0U) | (options.geometry ? 4U : 0U) |
         (options.adjacent == AdjacentPairs::kBeyondShared ? 8U : 0U);
}

// Implements the contract of makeCudaDetector() on settings.device, which must be usable. For one
// thread at a time. The order of the members matters: each part uses those before it.
class SingleGpuDetector : public PartitionDetector {
 public:
  explicit SingleGpuDetector(const CudaSettings& settings);
  ~SingleGpuDetector() override;

  std::string backend() const override { return "cuda"; }
  void reset() override { upload_.reset(); }
  void swapResult(DetectionResult& result) override { result_.swap(result); }
  std::pmr::memory_resource& vertexMemory() override;
  void setPartition(const ScenePartition& partition) override { upload_.setPartition(partition); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override;

 private:
  void findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                    const Stopwatch& watch);
  void addTimes(double upload_ms, double output_ms, bool swept);
  // Stops the work that a cycle may have left, and waits for it, before memory is freed.
  void endWork();

  DetectionResult result_;
  DeviceCycle cycle_;
  CycleUpload upload_{cycle_};
  ContactCollector collector_{cycle_, result_};
  CycleRunner runner_{cycle_, collector_};
};

SingleGpuDetector::SingleGpuDetector(const CudaSettings& settings) : cycle_(settings) {
  result_.contacts.moveTo(pinnedMemory());
  result_.geometry.moveTo(pinnedMemory());
}

SingleGpuDetector::~SingleGpuDetector() {
  cudaSetDevice(cycle_.settings.device);
  endWork();
}

void SingleGpuDetector::endWork() {
  cycle_.stop.set();
  cudaStreamSynchronize(cycle_.stream.get());
  runner_.waitForBranches();
}

std::pmr::memory_resource& SingleGpuDetector::vertexMemory() { return pinnedOrPlainMemory(); }

const DetectionResult& SingleGpuDetector::detect(const Scene& scene, const Options& options) {
  const Stopwatch watch{};
  requireValid(options);
  checkCuda(cudaSetDevice(cycle_.settings.device), "cudaSetDevice");
  cudaGetLastError();  // clears an error that this thread has from another device
  const CycleLimit limit(options.limits);
  result_.begin(scene, options, isGuaranteed(options));
  cycle_.stop.clear();
  if (limit.over()) {
    result_.cutOff(limit.why());
  } else {
    try {
      findContacts(scene, options, limit, watch);
    } catch (...) {
      // Copies from this scene may be under way, and the caller may change it.
      endWork();
      throw;
    }
  }
  result_.round_trip_ms = watch.elapsedMs();
  upload_.endDetection();
  return result_;
}

// Detects the contacts of a scene. `watch` was started at the beginning of the cycle.
void SingleGpuDetector::findContacts(const Scene& scene, const Options& options,
                                     const CycleLimit& limit, const Stopwatch& watch) {
  if (!upload_.send(scene, options, limit, result_)) {
    if (limit.wasOver()) result_.cutOff(limit.why());
    return;
  }
  const double upload_ms = watch.elapsedMs();
  const bool all = runner_.run(options, limit);
  const CycleCounters& counted = cycle_.counted();
  const bool listed = collector_.addTo(options);
  const bool searched = cycle_.nearest.addTo(scene, cycle_.scene.tables(), result_);
  if (limit.wasOver() && !(all && listed && searched && collector_.allDecided())) {
    result_.cutOff(limit.why());
  }
  if (counted.unexamined > 0 || !collector_.hadRoomForOpenPairs()) {
    result_.cutOff("memory_limit_mib");
  }
  giveDistances(scene, options, searched, &result_);
  // A tile whose list of clusters had no room reports its pairs in every cluster, so some pairs may
  // be found several times.
  if (counted.list_words > cycle_.sizes.list_words) dropRepeated(result_);
  result_.detect_ms = runner_.deviceMs() + collector_.decideMs();
  result_.detector_bytes = cycle_.memory.bytes() + collector_.bytes();
  const MemoryUse use = ProcessMemory::of(cycle_.settings.device).afterCycle(kernelsOf(options));
  result_.memory_bytes = std::max(use.bytes, result_.detector_bytes);
  result_.memory_is_whole = use.is_whole;
  result_.counters.posed = cycle_.scene.triangleCount();
  reportCounters(counted, cycle_.sizes.clusters, result_.counters);
  cycle_.scene.listRejectedParts(scene, result_, cycle_.stream.get());
  result_.counters.exact += collector_.decidedOnHost();
  upload_.endCycle(options, result_.started_cold);
  addTimes(upload_ms, watch.elapsedMs() - upload_ms - result_.detect_ms,
           options.motion == Motion::kSwept);
}

// Fills in the times of the stages [ms]. Without CudaSettings::time_stages the device's stages are
// one item, because single ones are not timed.
void SingleGpuDetector::addTimes(double upload_ms, double output_ms, bool swept) {
  const double decide_ms = collector_.decideMs();
  if (cycle_.settings.time_stages) {
    StageTimes times = runner_.stageTimes();
    times.add(Stage::kOutput, output_ms);
    result_.stages_ms = times.byName();
  } else {
    result_.stages_ms = {{"upload", upload_ms},
                         {"transform_to_narrow_phase", result_.detect_ms - decide_ms},
                         {kStageNames[static_cast<int>(Stage::kOutput)], output_ms}};
  }
  if (swept) result_.stages_ms.emplace_back("narrow_phase_on_host", decide_ms);
}

// Runs cycles with such options on a tiny scene: step by step, and as a recorded graph.
void runTinyScene(SingleGpuDetector& detector, Options options) {
  Scene scene;
  scene.addBody("", {{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.1F}, {0, 1, 2, 1, 3, 2}});
  scene.addBody("", {{0.2F, 0.2F, -1, 0.2F, 0.3F, 1, 0.3F, 0.2F, 1}, {0, 1, 2}});
  scene.setPairEnabled(0, 0, true);
  scene.setPairEnabled(0, 1, true);
  scene.setEarlier(1, RigidTransform());
  if (options.nearest) scene.setMargin(1, 1);
  options.clusters = 2;
  for (int i = 0; i < 3; ++i) detector.detect(scene, options);  // the third is a recorded graph
}

// Loads the kernels that cycles with such options need, once for each device of the process; for
// swept motion also those of instant motion. CUDA loads a kernel when it runs for the first time,
// and enlarges the memory for the stacks of all threads that the device can hold if that kernel
// needs more. Both take longer than a cycle. So kernels that are asked for are run here, and others
// are left to the first cycle that needs them.
void loadKernels(int device, const Options& warm_up) {
  static std::mutex mutex;
  static std::set<std::pair<int, unsigned>> loaded;
  const std::lock_guard<std::mutex> lock(mutex);
  const std::pair<int, unsigned> kernels(device, kernelsOf(warm_up));
  if (loaded.count(kernels) > 0) return;
  CudaSettings settings;
  settings.device = device;
  SingleGpuDetector detector(settings);
  Options options;
  options.adjacent = warm_up.adjacent;
  options.nearest = warm_up.nearest;
  options.geometry = warm_up.geometry;
  runTinyScene(detector, options);
  if (warm_up.motion == Motion::kSwept) {
    options.motion = Motion::kSwept;
    options.geometry = false;
    for (const bool times : {false, true}) {
      options.first_times = times;
      runTinyScene(detector, options);
    }
  }
  loaded.insert(kernels);
}

}  // namespace

std::unique_ptr<PartitionDetector> makeCudaPartitionDetector(const CudaSettings& settings) {
  requireUsable(settings.device);
  loadKernels(settings.device, settings.warm_up);
  return std::make_unique<SingleGpuDetector>(settings);
}

std::unique_ptr<Detector> makeCudaDetector(const CudaSettings& settings) {
  return makePartitionedDetector(settings, makeCudaPartitionDetector);
}

}  // namespace deformable_contact_monitor
