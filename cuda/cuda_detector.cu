#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/rules/cluster_count.h"
#include "core/stopwatch.h"
#include "cuda/cold_start.h"
#include "cuda/cuda_detector.h"
#include "cuda/cycle_graph.cuh"
#include "cuda/device/usable_device.cuh"
#include "cuda/memory/device_scene.cuh"
#include "cuda/memory/host_stop.cuh"
#include "cuda/open_pairs.cuh"
#include "cuda/stages/output.cuh"

namespace deformable_contact_monitor {
namespace {

// Bounds the time that a tiny memory limit can cost.
constexpr std::uint32_t kMostPasses = 4096;

class CudaDetector : public Detector {
 public:
  explicit CudaDetector(const CudaSettings& settings)
      : settings_(settings),
        device_(DeviceTraits::of(settings.device)),
        cluster_counts_{500, 8192, 1600, device_.multiprocessors} {}
  ~CudaDetector() override {
    cudaSetDevice(settings_.device);
    stop_.set();
    cudaStreamSynchronize(stream_.get());
  }
  std::string backend() const override { return "cuda"; }
  void reset() override { cold_ = true; }
  const DetectionResult& detect(const Scene& scene, const Options& options) override;

 private:
  void findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                    const Stopwatch& watch);
  bool upload(const Scene& scene, const Options& options, const CycleLimit& limit);
  bool startCold(const Scene& scene, const Options& options, const CycleLimit& limit);
  void makeArrays();
  void sendParams();
  void sizeBins(const Options& options);
  void runCycle(const Options& options);
  bool runUntilItFits(const Options& options, const CycleLimit& limit);
  bool runInPasses(const Options& options, const CycleLimit& limit);
  bool isCutOff(const CycleLimit& limit) const;
  bool makeRoom();
  bool sweepInPasses(const Options& options, const CycleLimit& limit);
  void fetchContacts(const Options& options, bool few);
  void decideOpenPairs(const Options& options, const CycleLimit& limit);
  CycleShape shapeOf(const Options& options, bool identify, int refinements) const;
  void wait(const CycleLimit& limit) { stop_.wait(stream_, limit); }
  std::uint32_t listable(std::uint64_t contacts) const {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(contacts, sizes_.contacts));
  }
  bool isOutgrown(const CycleCounters& counted, const Options& options) const;

  CudaSettings settings_;
  const DeviceTraits device_;
  const ClusterCountPolicy cluster_counts_;
  CudaStream stream_;
  CudaEvent cycle_start_, cycle_end_;
  DeviceMemory memory_;
  CycleSizes sizes_;
  CycleArrays arrays_{memory_};
  DeviceScene scene_{settings_.device, memory_, sizes_, arrays_.scene};
  CycleGraph graphs_[2];  // with and without refinement of the prototypes
  PinnedBuffer<CycleParams> params_{1};
  PinnedBuffer<CycleCounters> counters_{1};
  HostStop stop_;
  ContactOutput output_;
  OpenPairs open_pairs_;  // in swept motion
  double decide_ms_ = 0;  // what they took in this cycle
  SceneScale scale_;
  SizeRule size_rule_;
  bool cold_ = true;
  Motion motion_ = Motion::kInstant;  // of the last cycle
  int asked_clusters_ = 0;            // by the options of the last cold start
  std::uint32_t large_at_start_ = 0;
  std::uint64_t last_contacts_ = 0;
  int cycles_since_refresh_ = 0;
  DetectionResult result_;
};

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
  if (limit.wasOver() && !(all && listed)) result_.cutOff(limit.why());
  if (counted.unjudged > 0) result_.cutOff("memory_limit_mib");
  if (counted.list_words > sizes_.list_words) dropRepeated(result_);
  result_.detect_ms = CudaEvent::between(cycle_start_, cycle_end_) + decide_ms_;
  result_.memory_bytes = memory_.bytes() + output_.bytes();
  result_.counters.posed = scene_.triangleCount();
  tell(counted, sizes_.clusters, result_.counters);
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
  return {device_, identify, refinements, swept, swept && sharers, pads};
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

// Runs cycles until all that one finds has room, and fetches the contacts. False if the limit was
// over before that: then they are what the last one found.
bool CudaDetector::runUntilItFits(const Options& options, const CycleLimit& limit) {
  constexpr int kMostTries = 16;
  bool all = false;
  decide_ms_ = 0;
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
  }
  const bool too_many =
      counters_[0].candidates > sizes_.candidates || counters_[0].open_pairs > sizes_.open_pairs;
  const bool in_passes = too_many && !limit.over();
  if (in_passes) {
    all = runInPasses(options, limit);
  } else if (all) {
    decideOpenPairs(options, limit);
  }
  if (in_passes || listable(counters_[0].contacts) > output_.fetched()) {
    last_contacts_ = counters_[0].contacts;
    fetchContacts(options, limit.over());
    wait(limit);
  }
  return all && counters_[0].candidates <= sizes_.candidates;
}

void CudaDetector::decideOpenPairs(const Options& options, const CycleLimit& limit) {
  const Stopwatch watch{};
  open_pairs_.decide(arrays_, std::min(counters_[0].open_pairs, sizes_.open_pairs), options, limit,
                     stream_.get());
  decide_ms_ += watch.elapsedMs();
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

// More candidates than memory: judges them in several passes over the work units and blocks. Those
// that no pass has room for are counted, not judged. False if the limit was over before the last.
bool CudaDetector::sweepInPasses(const Options& options, const CycleLimit& limit) {
  const cudaStream_t stream = stream_.get();
  const CycleShape shape = shapeOf(options, false, 0);
  const std::uint32_t most =
      std::min(kMostPasses, std::max(counters_[0].units, largeBlocks(arrays_)));
  const std::uint64_t found = counters_[0].judged + counters_[0].unjudged;
  auto passes =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(most, found / sizes_.candidates + 2));
  while (true) {
    bool fits = true;
    open_pairs_.clear();
    for (std::uint32_t pass = 0; pass < passes && (fits || passes == most); ++pass) {
      params_[0].pass = pass;
      params_[0].passes = passes;
      sendParams();
      launchRestart(arrays_, pass == 0, stream);
      launchSweep(arrays_, shape, stream);
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

}  // namespace

std::unique_ptr<Detector> makeCudaDetector(const CudaSettings& settings) {
  requireUsable(settings.device);
  return std::make_unique<CudaDetector>(settings);
}

}  // namespace deformable_contact_monitor
