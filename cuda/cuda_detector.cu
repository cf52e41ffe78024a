#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "core/rules/cluster_count.h"
#include "cuda/cold_start.h"
#include "cuda/cuda_detector.h"
#include "cuda/cycle_graph.cuh"
#include "cuda/device/boxes.cuh"
#include "cuda/memory/cycle_buffers.cuh"
#include "cuda/memory/device_scene.cuh"
#include "cuda/stages/contact_output.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

class CudaDetector : public Detector {
 public:
  explicit CudaDetector(const CudaSettings& settings)
      : settings_(settings),
        device_(DeviceTraits::of(settings.device)),
        cluster_counts_{500, 8192, 1600, device_.multiprocessors} {}
  ~CudaDetector() override {
    cudaSetDevice(settings_.device);
    cudaStreamSynchronize(stream_.get());
  }
  std::string backend() const override { return "cuda"; }
  void reset() override { cold_ = true; }
  const DetectionResult& detect(const Scene& scene, const Options& options) override;

 private:
  void run(const Scene& scene, const Options& options);
  void startCold(const Scene& scene, const Options& options);
  void setParams(const Options& options);
  void sendParams();
  void sizeBinsFirst();
  void runCycle(const Options& options);
  bool makeRoom();
  void sweepInPasses();
  void fetchContacts(std::uint64_t count);
  std::uint32_t listable(std::uint64_t contacts) const {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(contacts, sizes_.contacts));
  }
  void publish(const Options& options);
  void prepareView();
  bool needsColdStart(const Options& options);

  CudaSettings settings_;
  const DeviceTraits device_;
  const ClusterCountPolicy cluster_counts_;
  CudaStream stream_;
  CudaEvent cycle_start_, cycle_end_;
  DeviceScene scene_;
  CycleBuffers buffers_;
  CycleSizes sizes_;
  CycleView view_{};
  CycleGraph graphs_[2];  // with and without refinement of the prototypes
  CycleShape shape_;
  PinnedBuffer<CycleParams> params_;
  ContactOutput output_;
  SceneScale scale_;
  SizeRule size_rule_;
  bool cold_ = true;
  int asked_clusters_ = -1;  // by the options
  std::uint32_t clusters_ = 0;
  std::uint32_t large_at_start_ = 0;
  std::uint64_t last_contacts_ = 0;
  int cycles_since_refresh_ = 0;
  DetectionResult result_;
};

const DetectionResult& CudaDetector::detect(const Scene& scene, const Options& options) {
  requireValid(options);
  checkCuda(cudaSetDevice(settings_.device), "cudaSetDevice");
  const auto start = Clock::now();
  result_.stages_ms.clear();
  result_.left_out = 0;
  result_.detect_ms = 0;
  result_.counters = Counters();
  result_.counters.triangles = scene.triangleCount();
  result_.guaranteed = options.overlap == 1 && options.predicates != Predicates::kFast;
  run(scene, options);
  result_.round_trip_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  return result_;
}

void CudaDetector::startCold(const Scene& scene, const Options& options) {
  const ColdStart start = measureScene(scene, options, cluster_counts_);
  scale_ = start.scale;
  size_rule_ = start.size_rule;
  large_at_start_ = static_cast<std::uint32_t>(start.large);
  clusters_ = static_cast<std::uint32_t>(start.seeds.size());
  sizes_.prepare(scene_.triangleCount(), static_cast<std::uint32_t>(start.regular), clusters_,
                 settings_.memory_limit_bytes);
  for (CycleGraph& graph : graphs_) graph.forget();
  prepareView();

  std::vector<ClusterFrame> frames(clusters_);
  for (ClusterFrame& frame : frames) {
    for (int k = 0; k < 3; ++k) {
      frame.axes.axis[k] = {k == 0 ? 1.0F : 0.0F, k == 1 ? 1.0F : 0.0F, k == 2 ? 1.0F : 0.0F};
      frame.along[k] = frame.world[k] = frame.world[3] = Quantiser(-1, 1);
    }
  }
  const cudaStream_t stream = stream_.get();
  const auto put = [&](auto* to, const auto& from) {
    checkCuda(cudaMemcpyAsync(to, from.data(), from.size() * sizeof(from[0]),
                              cudaMemcpyHostToDevice, stream),
              "cudaMemcpyAsync to the device");
  };
  const auto clear = [&](auto* what, std::size_t count) {
    checkCuda(cudaMemsetAsync(what, 0, count * sizeof(*what), stream), "cudaMemsetAsync");
  };
  put(view_.prototypes, start.seeds);
  put(view_.frames, frames);
  clear(view_.bins, clusters_ + 1);
  clear(view_.next_bins, clusters_ + 1);
  clear(view_.member_count, (clusters_ + 1) * std::size_t{kCountStride});
  clear(view_.membership_sums, clusters_);
  clear(view_.list_reach, clusters_);
  clear(view_.body_boxes, kSides * std::size_t{view_.body_count});
  clear(view_.far_count, 1);
  launchListNeighbours(view_, stream);
  stream_.synchronise();  // the host's arrays go
  cycles_since_refresh_ = 0;
}

void CudaDetector::prepareView() {
  if (buffers_.grow(sizes_)) {
    for (CycleGraph& graph : graphs_) graph.forget();
  }
  scene_.view(view_);
  buffers_.view(view_);
  view_.cluster_count = clusters_;
  view_.sample_count = sizes_.samples;
}

void CudaDetector::setParams(const Options& options) {
  params_.grow(1);
  params_[0] = scene_.params(options);
  params_[0].scale = scale_;
  params_[0].size = size_rule_;
}

void CudaDetector::sendParams() {
  checkCuda(cudaMemcpyAsync(const_cast<CycleParams*>(view_.params), params_.data(),
                            sizeof(CycleParams), cudaMemcpyHostToDevice, stream_.get()),
            "cudaMemcpyAsync to the device");
}

void CudaDetector::runCycle(const Options& options) {
  const cudaStream_t stream = stream_.get();
  sendParams();
  const bool refresh = clusters_ > 1 && ++cycles_since_refresh_ >= options.refresh_period;
  if (refresh) cycles_since_refresh_ = 0;
  shape_.device = device_;
  shape_.identify = scene_.anySelf();
  shape_.refinements = refresh ? options.iterations : 0;
  if (settings_.time_stages) {
    cycle_start_.record(stream);
    graphs_[0].runTimed(view_, shape_, stream);
    cycle_end_.record(stream);
    return;
  }
  CycleGraph& graph = graphs_[refresh ? 1 : 0];
  graph.prepare(view_, shape_, stream);
  cycle_start_.record(stream);
  graph.launch(stream);
  cycle_end_.record(stream);
}

// After a cycle that may have overflown: true if it fitted, else there is more room now.
bool CudaDetector::makeRoom() {
  const bool fits = view_.host_counters->bin_overflow == 0;
  const bool grown = sizes_.growFor(*view_.host_counters, settings_.memory_limit_bytes);
  if (grown) prepareView();
  return fits && !grown;
}

// More candidates than memory: judges them in several passes over the work units and blocks.
void CudaDetector::sweepInPasses() {
  const cudaStream_t stream = stream_.get();
  auto passes = static_cast<std::uint32_t>(view_.host_counters->judged / sizes_.candidates + 2);
  while (true) {
    bool fits = true;
    for (std::uint32_t pass = 0; pass < passes && fits; ++pass) {
      params_[0].pass = pass;
      params_[0].passes = passes;
      sendParams();
      launchRestart(view_, pass == 0, stream);
      launchSweep(view_, device_, stream);
      launchLarge(view_, stream);
      launchJudge(view_, device_, stream);
      checkCuda(cudaGetLastError(), "a launch");
      stream_.synchronise();
      fits = view_.host_counters->candidates <= sizes_.candidates;
    }
    cycle_end_.record(stream);
    if (fits) return;
    if (passes > std::max(view_.host_counters->units, largeBlocks(view_))) {
      throw CudaError("a single block has more candidates than the memory limit allows");
    }
    passes *= 2;
  }
}

void CudaDetector::fetchContacts(std::uint64_t count) {
  output_.fetch(view_, scene_.anyMargin(), params_[0].index_bits, listable(count), stream_.get());
}

// Without a cycle before, the bins have no size: part of one finds it.
void CudaDetector::sizeBinsFirst() {
  const cudaStream_t stream = stream_.get();
  sendParams();
  if (!scene_.anySelf()) launchIdentify(view_, stream);  // once is enough then
  launchPose(view_, device_, stream);
  launchAssign(view_, device_, stream);
  launchSizeBins(view_, stream);
  checkCuda(cudaMemsetAsync(view_.body_boxes, 0,
                            kSides * sizeof(std::uint32_t) * std::size_t{view_.body_count}, stream),
            "cudaMemsetAsync");
  checkCuda(cudaMemsetAsync(view_.far_count, 0, sizeof(std::uint32_t), stream), "cudaMemsetAsync");
}

bool CudaDetector::needsColdStart(const Options& options) {
  const bool asked_anew = asked_clusters_ != options.clusters;
  asked_clusters_ = options.clusters;
  return cold_ || asked_anew;
}

// Contacts as the result lists them, and what the next cycle should know.
void CudaDetector::publish(const Options& options) {
  const CycleCounters& c = *view_.host_counters;
  const std::uint32_t listed = listable(c.contacts);
  output_.list(scene_, listed, result_);
  result_.left_out = c.contacts - listed;
  last_contacts_ = c.contacts;

  Counters& counters = result_.counters;
  counters.rejected = c.rejected;
  counters.posed = scene_.triangleCount();
  counters.culled = c.culled;
  counters.clustered = c.clustered;
  counters.large = c.large;
  counters.clusters = c.clustered > 0 ? clusters_ : 0;
  counters.cluster_entries = c.entries;
  counters.largest_cluster = c.largest_cluster;
  counters.interval_overlaps = c.interval_overlaps;
  counters.candidates = c.judged;
  counters.exact = c.exact;
  counters.undecided = c.undecided;

  // A scene that has outgrown its clusters or its scale starts anew.
  const bool more_large = c.large > 2 * large_at_start_ + 64 + c.clustered / 64;
  const std::size_t wanted = clusterCountFor(options, cluster_counts_, c.clustered, clusters_);
  const bool other_count = options.clusters == 0 && std::max<std::size_t>(1, wanted) != clusters_;
  cold_ = more_large || other_count;
}

void CudaDetector::run(const Scene& scene, const Options& options) {
  const auto start = Clock::now();
  const cudaStream_t stream = stream_.get();
  const bool start_cold = needsColdStart(options);
  cold_ = true;  // until this cycle is over: what fails leaves the device's state in doubt
  const bool laid_out_anew = scene_.layOut(scene, stream);
  if (scene_.empty()) {
    result_.contacts.clear();
    result_.separations_m.clear();
    return;
  }
  if (start_cold || laid_out_anew) startCold(scene, options);
  scene_.send(scene, scale_, stream);
  setParams(options);
  const double upload_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  if (start_cold || laid_out_anew) sizeBinsFirst();
  constexpr int kMostTries = 16;
  for (int tries = 1;; ++tries) {
    runCycle(options);
    fetchContacts(last_contacts_);
    checkCuda(cudaGetLastError(), "a launch");
    stream_.synchronise();
    if (makeRoom()) break;
    if (tries == kMostTries) throw CudaError("the sizes of a cycle do not settle");
  }
  const CycleCounters& counters = *view_.host_counters;
  bool listed = listable(counters.contacts) <= output_.fetched();
  if (counters.candidates > sizes_.candidates) {
    do sweepInPasses();
    while (!makeRoom());
    listed = false;
  }
  if (!listed) {
    fetchContacts(counters.contacts);
    stream_.synchronise();
  }
  result_.detect_ms = CudaEvent::between(cycle_start_, cycle_end_);
  result_.memory_bytes = scene_.bytes() + buffers_.bytes() + output_.bytes();
  publish(options);
  if (settings_.time_stages) {
    result_.stages_ms = graphs_[0].times();
  } else {
    const double all_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    result_.stages_ms = {{"upload", upload_ms},
                         {"detect", result_.detect_ms},
                         {"output", all_ms - upload_ms - result_.detect_ms}};
  }
}

}  // namespace

std::unique_ptr<Detector> makeCudaDetector(const CudaSettings& settings) {
  int count = 0;
  checkCuda(cudaGetDeviceCount(&count), "no CUDA device can be used");
  if (settings.device < 0 || settings.device >= count) {
    throw CudaError("there is no CUDA device " + std::to_string(settings.device) + "; there are " +
                    std::to_string(count));
  }
  checkCuda(cudaSetDevice(settings.device), "cudaSetDevice");
  int major = 0, minor = 0;
  checkCuda(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, settings.device),
            "cudaDeviceGetAttribute");
  checkCuda(cudaDeviceGetAttribute(&minor, cudaDevAttrComputeCapabilityMinor, settings.device),
            "cudaDeviceGetAttribute");
  constexpr int kLeastCapability = 75;
  if (10 * major + minor < kLeastCapability) {
    throw CudaError("CUDA device " + std::to_string(settings.device) +
                    " is of compute capability " + std::to_string(major) + "." +
                    std::to_string(minor) + "; 7.5 or newer is needed");
  }
  return std::make_unique<CudaDetector>(settings);
}

}  // namespace deformable_contact_monitor
