#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/cluster_count.h"
#include "core/working_set.h"
#include "cuda/cuda_detector.h"
#include "cuda/cycle_buffers.cuh"
#include "cuda/cycle_graph.cuh"
#include "cuda/device_scene.cuh"
#include "cuda/stages.cuh"

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

constexpr ClusterCountPolicy kClusterCounts{500, 8192, 600};

class CudaDetector : public Detector {
 public:
  explicit CudaDetector(const CudaSettings& settings) : settings_(settings) {
    checkCuda(
        cudaDeviceGetAttribute(&multiprocessors_, cudaDevAttrMultiProcessorCount, settings.device),
        "cudaDeviceGetAttribute");
  }
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
  std::uint32_t withinLimit(std::uint64_t wanted, std::uint64_t bytes_each) const;
  bool makeRoom();
  void sweepInPasses();
  void fetchContacts(std::uint32_t count);
  std::uint32_t listable(std::uint64_t contacts) const {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(contacts, sizes_.contacts));
  }
  void publish(const Options& options);
  void prepareView();
  bool needsColdStart(const Options& options);

  CudaSettings settings_;
  int multiprocessors_ = 1;
  CudaStream stream_;
  CudaEvent cycle_start_, cycle_end_;
  DeviceScene scene_;
  CycleBuffers buffers_;
  CycleSizes sizes_;
  CycleView view_{};
  CycleGraph graphs_[2];  // with and without refinement of the prototypes
  CycleShape shape_;
  PinnedBuffer<CycleParams> params_;
  DeviceBuffer<std::uint64_t> sorted_keys_;
  DeviceBuffer<float> sorted_separations_;
  DeviceBuffer<unsigned char> scratch_;
  PinnedBuffer<std::uint64_t> keys_;
  PinnedBuffer<float> separations_;
  std::uint32_t fetched_ = 0;  // keys that the last output brought
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
  std::string refused;
  for (const std::string& line : problems(options)) refused += (refused.empty() ? "" : "; ") + line;
  if (!refused.empty()) throw std::invalid_argument(refused);
  checkCuda(cudaSetDevice(settings_.device), "cudaSetDevice");
  const auto start = Clock::now();
  result_.contacts.clear();
  result_.separations_m.clear();
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

// Sizes, scale and seeds as the CPU backend finds them. Costs milliseconds: for first cycles and
// changes of the scene's make-up.
void CudaDetector::startCold(const Scene& scene, const Options& options) {
  WorkingSet set;
  SizeSplit split;
  Counters counters;
  WorkingSetBuilder().build(scene, set, counters);
  splitBySize(set, split);
  scale_ = split.scale;
  size_rule_ = split.rule;
  large_at_start_ = static_cast<std::uint32_t>(split.large.size());
  const std::size_t regular = split.regular.size();
  clusters_ = static_cast<std::uint32_t>(
      std::max<std::size_t>(1, clusterCountFor(options, kClusterCounts, regular, 0)));
  std::vector<Vec3f> seeds(clusters_);
  for (std::size_t g = 0; g < seeds.size() && regular > 0; ++g) {
    const Triangle t = set.posed(split.regular[(2 * g + 1) * regular / (2 * seeds.size())]);
    seeds[g] = (scale_.apply(t.v[0]) + scale_.apply(t.v[1]) + scale_.apply(t.v[2])) * (1.0F / 3);
  }
  const std::uint32_t n = scene_.triangleCount();
  sizes_.triangles = n;
  sizes_.clusters = clusters_;
  sizes_.samples = std::min(n, std::max(1024U, 8 * clusters_));
  const auto in_clusters = static_cast<std::uint32_t>(regular);
  sizes_.members = std::max(sizes_.members, in_clusters * 2 + 48 * clusters_ + 256);
  sizes_.list_words = std::max(sizes_.list_words, in_clusters + 256);
  sizes_.units = std::max(sizes_.units, in_clusters / 6 + 4 * clusters_ + 256);
  sizes_.candidates = std::max(sizes_.candidates,
                               withinLimit(2 * in_clusters + 256, CycleBuffers::kCandidateBytes));
  sizes_.contacts =
      std::max(sizes_.contacts, withinLimit(in_clusters + 256, CycleBuffers::kContactBytes));
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
  put(view_.prototypes, seeds);
  put(view_.frames, frames);
  clear(view_.bins, clusters_ + 1);
  clear(view_.next_bins, clusters_ + 1);
  clear(view_.member_count, (clusters_ + 1) * std::size_t{kCountStride});
  clear(view_.membership_sums, clusters_);
  clear(view_.list_reach, clusters_);
  clear(view_.body_boxes, 6 * std::size_t{view_.body_count});
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
  CycleParams& p = params_[0];
  p = CycleParams();
  p.scale = scale_;
  p.size = size_rule_;
  p.overlap = options.overlap;
  p.fuzzifier = options.fuzzifier;
  p.adjacent = options.adjacent;
  p.predicates = options.predicates;
  p.margins = scene_.anyMargin() ? 1 : 0;
  p.class_count = scene_.classCount();
  p.classes_exact = scene_.classesExact() ? 1 : 0;
  std::uint32_t buckets = kBuckets;
  while (buckets * p.class_count > kBuckets) buckets /= 2;
  p.bucket_shift = 15;
  while (buckets > 1) {
    buckets /= 2;
    --p.bucket_shift;
  }
  // Small scenes have few units, which must be small to share them out evenly.
  constexpr std::uint32_t kManyTriangles = 300000;
  p.unit_columns = scene_.triangleCount() < kManyTriangles ? 32 : 64;
  p.pass = 0;
  p.passes = 1;
  p.index_bits = 1;
  while ((std::uint64_t{1} << p.index_bits) <= scene_.triangleCount()) ++p.index_bits;
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
  shape_.multiprocessors = static_cast<unsigned>(multiprocessors_);
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

// Candidates and contacts share the memory limit by halves.
std::uint32_t CudaDetector::withinLimit(std::uint64_t wanted, std::uint64_t bytes_each) const {
  constexpr std::uint64_t kMostPlaces = std::uint64_t{1} << 31;
  const std::uint64_t most = std::min(kMostPlaces, settings_.memory_limit_bytes / 2 / bytes_each);
  return static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(wanted, 1, std::max<std::uint64_t>(1, most)));
}

// After a cycle that may have overflown: true if it fitted, else there is more room now.
bool CudaDetector::makeRoom() {
  const CycleCounters& c = *view_.host_counters;
  const auto more = [](auto wanted) { return wanted + wanted / 4 + 256; };
  const CycleSizes before = sizes_;
  bool fits = c.bin_overflow == 0;
  if (c.bins_wanted > sizes_.members) sizes_.members = more(c.bins_wanted);
  if (c.list_words > sizes_.list_words) sizes_.list_words = more(c.list_words);
  if (c.units > sizes_.units) sizes_.units = more(c.units);
  if (c.candidates > sizes_.candidates) {
    sizes_.candidates =
        std::max(sizes_.candidates, withinLimit(more(c.candidates), CycleBuffers::kCandidateBytes));
  }
  if (c.contacts > sizes_.contacts) {
    sizes_.contacts =
        std::max(sizes_.contacts, withinLimit(more(c.contacts), CycleBuffers::kContactBytes));
  }
  constexpr std::uint32_t kMostMembers = 1U << 29;  // the sweep packs their places
  if (sizes_.members >= kMostMembers || sizes_.units > kMostMembers) {
    throw CudaError("the scene is too crowded for the CUDA backend");
  }
  const bool grown = before.members != sizes_.members || before.list_words != sizes_.list_words ||
                     before.units != sizes_.units || before.candidates != sizes_.candidates ||
                     before.contacts != sizes_.contacts;
  if (grown) prepareView();
  return fits && !grown;
}

// More candidates than memory: judges them in several passes over the work units.
void CudaDetector::sweepInPasses() {
  const cudaStream_t stream = stream_.get();
  const auto multiprocessors = static_cast<unsigned>(multiprocessors_);
  auto passes = static_cast<std::uint32_t>(view_.host_counters->candidates / sizes_.candidates + 2);
  while (true) {
    bool fits = true;
    for (std::uint32_t pass = 0; pass < passes && fits; ++pass) {
      params_[0].pass = pass;
      params_[0].passes = passes;
      sendParams();
      launchRestart(view_, pass == 0, stream);
      launchSweep(view_, multiprocessors, stream);
      launchLarge(view_, stream);
      launchJudge(view_, multiprocessors, stream);
      checkCuda(cudaGetLastError(), "a launch");
      stream_.synchronise();
      fits = view_.host_counters->candidates <= sizes_.candidates;
    }
    if (fits) return;
    if (passes > view_.host_counters->units) {
      throw CudaError("a single work unit has more candidates than the memory limit allows");
    }
    passes *= 2;
  }
}

// Sorts on the device and copies; a little more than last time's, so that the host need not know
// the count before.
void CudaDetector::fetchContacts(std::uint32_t count) {
  const cudaStream_t stream = stream_.get();
  const bool separations = scene_.anyMargin();
  const std::uint32_t capacity = std::min(sizes_.contacts, count + count / 4 + 1024);
  if (sorted_keys_.grow(capacity)) keys_.grow(sorted_keys_.size());
  if (separations && sorted_separations_.grow(sorted_keys_.size())) {
    separations_.grow(sorted_keys_.size());
  }
  float* const separations_out = separations ? sorted_separations_.data() : nullptr;
  const unsigned bits = params_[0].index_bits;
  std::size_t scratch_bytes = 0;
  sortContacts(view_, capacity, bits, sorted_keys_.data(), separations_out, nullptr, scratch_bytes,
               stream);
  scratch_.grow(scratch_bytes + 1);
  sortContacts(view_, capacity, bits, sorted_keys_.data(), separations_out, scratch_.data(),
               scratch_bytes, stream);
  sorted_keys_.download(keys_.data(), capacity, stream);
  if (separations) sorted_separations_.download(separations_.data(), capacity, stream);
  fetched_ = capacity;
}

// Without a cycle before, the bins have no size: part of one finds it.
void CudaDetector::sizeBinsFirst() {
  const cudaStream_t stream = stream_.get();
  sendParams();
  if (!scene_.anySelf()) launchIdentify(view_, stream);  // once is enough then
  launchPose(view_, stream);
  launchAssign(view_, static_cast<unsigned>(multiprocessors_), stream);
  launchSizeBins(view_, stream);
  checkCuda(cudaMemsetAsync(view_.body_boxes, 0,
                            6 * sizeof(std::uint32_t) * std::size_t{view_.body_count}, stream),
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
  const unsigned bits = params_[0].index_bits;
  const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
  result_.contacts.resize(listed);
  for (std::uint32_t i = 0; i < listed; ++i) {
    const auto a = static_cast<std::uint32_t>(keys_[i] >> bits);
    const auto b = static_cast<std::uint32_t>(keys_[i] & mask);
    result_.contacts[i] = {scene_.bodyOf(a), scene_.localOf(a), scene_.bodyOf(b),
                           scene_.localOf(b)};
  }
  if (scene_.anyMargin()) {
    result_.separations_m.assign(separations_.data(), separations_.data() + listed);
  }
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
  const std::size_t wanted = clusterCountFor(options, kClusterCounts, c.clustered, clusters_);
  const bool other_count = options.clusters == 0 && std::max<std::size_t>(1, wanted) != clusters_;
  cold_ = more_large || other_count;
}

void CudaDetector::run(const Scene& scene, const Options& options) {
  const auto start = Clock::now();
  const cudaStream_t stream = stream_.get();
  const bool start_cold = needsColdStart(options);
  cold_ = true;  // until this cycle is over: what fails leaves the device's state in doubt
  const bool laid_out_anew = scene_.layOut(scene, stream);
  if (scene_.empty()) return;
  if (start_cold || laid_out_anew) startCold(scene, options);
  scene_.send(scene, scale_, stream);
  setParams(options);
  const double upload_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  if (start_cold || laid_out_anew) sizeBinsFirst();
  constexpr int kMostTries = 16;
  for (int tries = 1;; ++tries) {
    runCycle(options);
    fetchContacts(listable(last_contacts_));
    checkCuda(cudaGetLastError(), "a launch");
    stream_.synchronise();
    if (makeRoom()) break;
    if (tries == kMostTries) throw CudaError("the sizes of a cycle do not settle");
  }
  const CycleCounters& counters = *view_.host_counters;
  const bool in_passes = counters.candidates > sizes_.candidates;
  while (counters.candidates > sizes_.candidates) {
    sweepInPasses();
    if (makeRoom()) break;
  }
  if (in_passes || listable(counters.contacts) > fetched_) {
    fetchContacts(listable(counters.contacts));
    stream_.synchronise();
  }
  result_.detect_ms = CudaEvent::between(cycle_start_, cycle_end_);
  result_.memory_bytes = scene_.bytes() + buffers_.bytes();
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
