#include <optional>
#include <vector>

#include "cuda/cold_start.h"
#include "cuda/cuda_cycles.cuh"
#include "cuda/device/usable_device.cuh"

namespace deformable_contact_monitor {

const DetectionResult& CudaDetector::detect(const Scene& scene, const Options& options) {
  requireValid(options);
  checkCuda(cudaSetDevice(settings_.device), "cudaSetDevice");
  const Stopwatch watch{};
  const CycleLimit limit(options.limits);
  result_.begin(scene, options, isGuaranteed(options));
  stop_.clear();
  if (limit.over()) {
    result_.cutOff(limit.why());
  } else {
    findContacts(scene, options, limit, watch);
  }
  result_.round_trip_ms = watch.elapsedMs();
  return result_;
}

// `watch` runs since the cycle began.
void CudaDetector::findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                                const Stopwatch& watch) {
  if (!upload(scene, options, limit)) {
    if (limit.wasOver()) result_.cutOff(limit.why());
    return;
  }
  const double upload_ms = watch.elapsedMs();
  const bool all = runUntilItFits(options, limit);
  const CycleCounters& counted = counters_[0];
  output_.list(scene_, std::min(listable(counted.contacts), output_.fetched()), limit, result_);
  result_.left_out = counted.contacts - result_.contacts.size();
  const bool listed = result_.contacts.size() >= listable(counted.contacts);
  open_pairs_.addTo(scene_, options, result_);
  if (limit.wasOver() && !(all && listed && all_decided_)) result_.cutOff(limit.why());
  if (counted.unjudged > 0) result_.cutOff("memory_limit_mib");
  if (counted.list_words > sizes_.list_words) dropRepeated(result_);
  result_.detect_ms = CudaEvent::between(cycle_start_, cycle_end_) + decide_ms_;
  result_.memory_bytes = memory_.bytes() + output_.bytes();
  result_.counters.posed = scene_.triangleCount();
  tell(counted, sizes_.clusters, result_.counters);
  result_.counters.exact += open_pairs_.taken();
  last_contacts_ = counted.contacts;
  cold_ = isOutgrown(counted, options);
  const double output_ms = watch.elapsedMs() - upload_ms - result_.detect_ms;
  if (settings_.time_stages) {
    StageTimes times = graphs_[0].times();
    times.add(Stage::kOutput, output_ms);
    result_.stages_ms = times.byName();
  } else {
    result_.stages_ms = {{"upload", upload_ms},
                         {"pose_to_judge", result_.detect_ms - decide_ms_},
                         {kStageNames[static_cast<int>(Stage::kOutput)], output_ms}};
  }
  if (options.motion == Motion::kSwept) {
    result_.stages_ms.emplace_back("judge_on_host", decide_ms_);
  }
}

// Brings the scene and the settings to the device; false if there is nothing to look at, or the
// limit was over.
bool CudaDetector::upload(const Scene& scene, const Options& options, const CycleLimit& limit) {
  const cudaStream_t stream = stream_.get();
  const bool was_cold = cold_ || asked_clusters_ != options.clusters || motion_ != options.motion;
  cold_ = true;  // until this cycle is over: what fails leaves the device's state in doubt
  motion_ = options.motion;
  const bool laid_out_anew = scene_.layOut(scene, motion_, stream);
  if (scene_.triangleCount() == 0) return false;
  scene_.sendVertices(scene, motion_, stream);
  const bool starts = was_cold || laid_out_anew;
  result_.started_cold = starts;
  if (starts && !startCold(scene, options, limit)) return false;
  scene_.sendBodies(scene, motion_, scale_, stream);
  params_[0] =
      cycleParams(options, scene_.triangleCount(), scene_.groupCount(), scene_.anyLengths());
  params_[0].scale = scale_;
  params_[0].size = size_rule_;
  params_[0].limited = limit.isSet() ? 1 : 0;
  if (starts) sizeBins(options);
  return true;
}

// What the first cycle of a scene needs and others take over from the one before. False if the
// limit was over.
bool CudaDetector::startCold(const Scene& scene, const Options& options, const CycleLimit& limit) {
  std::optional<Scene> on_host;
  if (scene_.anyFromDevice()) on_host = scene_.onHost(scene, stream_.get());
  const ColdStart start = measureScene(on_host ? *on_host : scene, options, cluster_counts_, limit);
  if (limit.wasOver()) return false;
  asked_clusters_ = options.clusters;
  scale_ = start.scale;
  size_rule_ = start.size_rule;
  large_at_start_ = static_cast<std::uint32_t>(start.large);
  sizes_.prepare(static_cast<std::uint32_t>(start.regular),
                 static_cast<std::uint32_t>(start.seeds.size()), settings_.memory_limit_bytes);
  makeArrays();

  std::vector<ClusterFrame> frames(start.seeds.size());
  for (ClusterFrame& frame : frames) {
    for (int k = 0; k < 3; ++k) {
      frame.axes.axis[k] = {k == 0 ? 1.0F : 0.0F, k == 1 ? 1.0F : 0.0F, k == 2 ? 1.0F : 0.0F};
      frame.along[k] = frame.world[k] = frame.world[3] = Quantiser(-1, 1);
    }
  }
  const cudaStream_t stream = stream_.get();
  const auto put = [stream](auto* to, const auto& from) {
    checkCuda(cudaMemcpyAsync(to, from.data(), from.size() * sizeof(from[0]),
                              cudaMemcpyHostToDevice, stream),
              "cudaMemcpyAsync to the device");
  };
  put(arrays_.clusters.prototypes.data(), start.seeds);
  put(arrays_.sweep.frames.data(), frames);
  // No list says how far it reaches, no bin has room.
  checkCuda(
      cudaMemsetAsync(arrays_.clusters.list_reach.data(), 0, frames.size() * sizeof(float), stream),
      "cudaMemsetAsync");
  checkCuda(cudaMemsetAsync(arrays_.members.next_bins.data(), 0, (frames.size() + 1) * sizeof(Bin),
                            stream),
            "cudaMemsetAsync");
  launchClusterLists(arrays_, stream);
  stream_.synchronise();  // the host's arrays go
  cycles_since_refresh_ = 0;
  return true;
}

// Arrays of the sizes; recorded graphs know other ones.
void CudaDetector::makeArrays() {
  memory_.grow(sizes_);
  arrays_.clusters.count = sizes_.clusters;
  arrays_.clusters.sample_count = sizes_.samples;
  arrays_.host_counters.pointTo(counters_.data());
  arrays_.host_stop.pointTo(stop_.word());
  for (CycleGraph& graph : graphs_) graph.forget();
}

void CudaDetector::sendParams() {
  checkCuda(cudaMemcpyAsync(arrays_.the_params.data(), params_.data(), sizeof(CycleParams),
                            cudaMemcpyHostToDevice, stream_.get()),
            "cudaMemcpyAsync to the device");
}

// Without a cycle before, the bins have no room: part of one finds out how much they need. And
// every vertex is its own where no body touches itself: once is enough then.
void CudaDetector::sizeBins(const Options& options) {
  const CycleShape shape = shapeOf(options, true, 0);
  const cudaStream_t stream = stream_.get();
  sendParams();
  launchPoseIdentities(arrays_, shape, stream);
  launchPose(arrays_, shape, stream);
  launchAssign(arrays_, shape, stream);
  launchAssignBins(arrays_, shape, stream);
}

CycleShape CudaDetector::shapeOf(const Options& options, bool identify, int refinements) const {
  const bool sharers = scene_.anySelf() && options.adjacent == AdjacentPairs::kBeyondShared;
  const bool swept = options.motion == Motion::kSwept;
  const bool pads = swept && scene_.anyLengths().pads;
  const bool fans = identify && sharers && !swept && options.predicates == Predicates::kExact;
  return {device_,          identify, refinements, swept,
          swept && sharers, pads,     fans,        params_[0].leaves_few != 0};
}

void CudaDetector::runCycle(const Options& options) {
  const cudaStream_t stream = stream_.get();
  sendParams();
  const bool refresh = sizes_.clusters > 1 && ++cycles_since_refresh_ >= options.refresh_period;
  if (refresh) cycles_since_refresh_ = 0;
  const CycleShape shape = shapeOf(options, scene_.anySelf(), refresh ? options.iterations : 0);
  if (settings_.time_stages) {
    cycle_start_.record(stream);
    graphs_[0].runTimed(arrays_, shape, stream);
  } else {
    CycleGraph& graph = graphs_[refresh ? 1 : 0];
    graph.prepare(arrays_, shape, stream);
    cycle_start_.record(stream);
    graph.launch(stream);
  }
  cycle_end_.record(stream);
}

// Behind what is in the stream, as many contacts as there were last time; `few`: no more than are
// sorted and copied in little time.
void CudaDetector::fetchContacts(const Options& options, bool few) {
  const std::uint64_t most = few ? kMostListedLate : last_contacts_;
  const bool swept = options.motion == Motion::kSwept;
  const BodyLengths any = scene_.anyLengths();
  output_.fetch(arrays_,
                {any.margins && !swept, options.geometry, options.first_times, any.pads && swept},
                params_[0].index_bits, listable(std::min(last_contacts_, most)), stream_.get());
}

// A scene that has outgrown its clusters or its scale starts anew.
bool CudaDetector::isOutgrown(const CycleCounters& counted, const Options& options) const {
  const bool more_large = counted.large > 2 * large_at_start_ + 64 + counted.clustered / 64;
  const std::size_t wanted =
      clusterCountFor(options.clusters, cluster_counts_, counted.clustered, sizes_.clusters);
  const bool other_count =
      options.clusters == 0 && std::max<std::size_t>(1, wanted) != sizes_.clusters;
  return more_large || other_count;
}

std::unique_ptr<Detector> makeCudaDetector(const CudaSettings& settings) {
  requireUsable(settings.device);
  return std::make_unique<CudaDetector>(settings);
}

}  // namespace deformable_contact_monitor
