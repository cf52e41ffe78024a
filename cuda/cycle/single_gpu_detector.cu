// Runs one detection on one GPU: upload, stages, collection, and the figures of the result.
#include "cuda/cycle/single_gpu_detector.cuh"
#include "cuda/memory/pinned_memory.cuh"

namespace deformable_contact_monitor {

SingleGpuDetector::SingleGpuDetector(const CudaSettings& settings) : cycle_(settings) {
  result_.contacts.moveTo(pinnedMemory());
}

// Stops the work that a cycle may have left, and waits for it before memory is freed.
SingleGpuDetector::~SingleGpuDetector() {
  cudaSetDevice(cycle_.settings.device);
  cycle_.stop.set();
  cudaStreamSynchronize(cycle_.stream.get());
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
    findContacts(scene, options, limit, watch);
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
  if (limit.wasOver() && !(all && listed && collector_.allDecided())) result_.cutOff(limit.why());
  if (counted.unexamined > 0) result_.cutOff("memory_limit_mib");
  // A tile whose list of clusters had no room reports its pairs in every cluster, so some pairs may
  // be found several times.
  if (counted.list_words > cycle_.sizes.list_words) dropRepeated(result_);
  result_.detect_ms = runner_.deviceMs() + collector_.decideMs();
  result_.memory_bytes = cycle_.memory.bytes() + collector_.bytes();
  result_.counters.posed = cycle_.scene.triangleCount();
  reportCounters(counted, cycle_.sizes.clusters, result_.counters);
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
  if (swept) result_.stages_ms.emplace_back("judge_on_host", decide_ms);
}

}  // namespace deformable_contact_monitor
