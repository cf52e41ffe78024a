#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <set>
#include <vector>

#include "core/common/parallel.h"
#include "cuda/cycle/cuda_cycles.cuh"
#include "cuda/device/usable_device.cuh"
#include "cuda/partitions/partitioned_detector.h"

namespace deformable_contact_monitor {
namespace {

// A scene of which one part in so many triangles is new may be another one.
constexpr std::uint64_t kNewShare = 16;

// Whether certificates of fans are of use to bodies that have contacts with themselves.
bool asksForFans(const Options& options) {
  return options.motion == Motion::kInstant && options.adjacent == AdjacentPairs::kBeyondShared &&
         options.predicates == Predicates::kExact;
}

}  // namespace

const DetectionResult& CudaDetector::detect(const Scene& scene, const Options& options) {
  const Stopwatch watch{};
  requireValid(options);
  checkCuda(cudaSetDevice(settings_.device), "cudaSetDevice");
  cudaGetLastError();  // of another device, by this thread
  const CycleLimit limit(options.limits);
  result_.begin(scene, options, isGuaranteed(options));
  stop_.clear();
  if (limit.over()) {
    result_.cutOff(limit.why());
  } else {
    findContacts(scene, options, limit, watch);
  }
  result_.round_trip_ms = watch.elapsedMs();
  if (!cold_) scene_.groupAgain(stream_.get());
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
  output_.list(listable(counted.contacts), result_);
  result_.left_out = counted.contacts - result_.contacts.size();
  const bool listed = result_.contacts.size() >= listable(counted.contacts);
  open_pairs_.addTo(scene_, options, result_);
  if (limit.wasOver() && !(all && listed && all_decided_)) result_.cutOff(limit.why());
  if (counted.unjudged > 0) result_.cutOff("memory_limit_mib");
  if (counted.list_words > sizes_.list_words) dropRepeated(result_);
  result_.detect_ms = earlier_ms_ + CudaEvent::between(cycle_start_, cycle_end_) + decide_ms_;
  result_.memory_bytes = memory_.bytes() + output_.bytes();
  result_.counters.posed = scene_.triangleCount();
  tell(counted, sizes_.clusters, result_.counters);
  result_.counters.exact += open_pairs_.taken();
  last_contacts_ = counted.contacts;
  noteGrowth(counted, options);
  const double output_ms = watch.elapsedMs() - upload_ms - result_.detect_ms;
  if (settings_.time_stages) {
    StageTimes times = graphs_[0].times();
    times.add(Stage::kOutput, output_ms);
    result_.stages_ms = times.byName();
  } else {
    result_.stages_ms = {{"upload", upload_ms},
                         {"transform_to_narrow_phase", result_.detect_ms - decide_ms_},
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
  if (!was_cold) sizes_.growAhead(counters_[0], settings_.memory_limit_bytes);
  const bool reseeds = !was_cold && wanted_clusters_ != sizes_.clusters;
  if (reseeds) sizes_.prepareClusters(wanted_clusters_);
  const std::uint32_t samples = arrays_.clusters.sample_count;
  cold_ = true;  // until this cycle is over: what fails leaves the device's state in doubt
  copies_.forget();
  if (was_cold) {
    params_sent_ = false;
    scene_.forgetSent();
    stream_.synchronise();  // a cycle that failed may have left work that knows the host's memory
  }
  motion_ = options.motion;
  const DeviceScene::Change change = scene_.layOut(scene, motion_, asksForFans(options));
  if (scene_.triangleCount() == 0) return false;
  result_.started_cold = was_cold;
  const bool looks = isToBeLookedAt(change) || was_cold;
  const bool on_host = !scene_.anyFromDevice();
  ColdStart start;
  // A first scene is looked at first, for then its memory comes at once.
  const bool looks_first = was_cold && on_host;
  if (looks_first && !adaptTo(scene, change, options, limit, start)) return false;
  BesideTask glance;
  if (looks && !was_cold && on_host) {
    glance.start([&] { start = look(scene, options, limit, Look::kGlance); });
  }
  scene_.sendLayout(scene, stream);
  scene_.sendVertices(scene, motion_, copies_, stream);
  if (looks) copies_.launch();  // a look may end the cycle, or take a while
  if (!was_cold) group(scene, options, change.any);
  glance.wait();
  if (looks && !looks_first) {
    const bool adapted = on_host
                             ? adaptTo(scene, change, options, limit, start)
                             : adaptTo(scene_.onHost(scene, stream), change, options, limit, start);
    if (!adapted) {
      stream_.synchronise();  // from here on the caller may change what is being sent
      return false;
    }
  }
  makeArrays();
  if (result_.started_cold) {
    startCold(start, options);
    group(scene, options, true);
  } else if (reseeds) {
    launchClusterSeeds(arrays_, samples, stream);
    launchClusterStart(arrays_, stream);
    cycles_since_refresh_ = 0;
  }
  setParams(options, limit);
  const bool any_new = result_.started_cold || reseeds;
  if (any_new || change.more_triangles > 0) sizeBins(options, any_new);
  return true;
}

// Of the scene as it is laid out.
void CudaDetector::setParams(const Options& options, const CycleLimit& limit) {
  params_[0] =
      cycleParams(options, scene_.triangleCount(), scene_.groupCount(), scene_.anyLengths());
  params_[0].scale = scale_;
  params_[0].size = size_rule_;
  params_[0].limited = limit.isSet() ? 1 : 0;
  params_[0].share = share_;
  params_[0].any_self = scene_.anySelf() ? 1 : 0;
  params_[0].fans = scene_.anySelf() && asksForFans(options) ? 1 : 0;
}

// What the device makes of a scene that is there, of what is new of it, if anything is.
void CudaDetector::group(const Scene& scene, const Options& options, bool any_new) {
  scene_.sendBodies(scene, motion_, scale_, copies_);
  if (any_new) copies_.launch();
  scene_.group(stream_.get());
  if (scene_.anySelf() && asksForFans(options)) scene_.findFans(stream_.get());
}

ColdStart CudaDetector::look(const Scene& scene, const Options& options, const CycleLimit& limit,
                             Look how) {
  return measurer_.measure(scene, share_, options, cluster_counts_, how, limit);
}

// Sizes and rules to a first scene, or to one whose make-up changed: it starts cold, unless the
// clusters of the scene before do for it. `start`: a glance at the scene, if there was one. False
// if the limit was over.
bool CudaDetector::adaptTo(const Scene& scene, const DeviceScene::Change& change,
                           const Options& options, const CycleLimit& limit, ColdStart& start) {
  if (!result_.started_cold) {
    if (start.seeds.empty()) start = look(scene, options, limit, Look::kGlance);
    result_.started_cold = !isAlike(start, change, options);
  }
  if (result_.started_cold) {
    start = look(scene, options, limit, sample_misled_ ? Look::kAll : Look::kSample);
  }
  if (limit.wasOver()) return false;
  come_and_gone_ = 0;
  size_rule_ = start.size_rule;
  large_at_start_ = static_cast<std::uint32_t>(start.large);
  const std::size_t clusters = result_.started_cold ? start.seeds.size() : sizes_.clusters;
  sizes_.prepare(static_cast<std::uint32_t>(start.regular), static_cast<std::uint32_t>(clusters),
                 settings_.memory_limit_bytes);
  return true;
}

// Where a small part of a scene comes, goes or is replaced, what was found for the whole still
// does. Small parts add up until there is a look.
bool CudaDetector::isToBeLookedAt(const DeviceScene::Change& change) {
  come_and_gone_ += change.more_triangles + change.fewer_triangles + change.replaced_triangles;
  return kNewShare * come_and_gone_ > scene_.triangleCount();
}

// Whether clusters that fitted the scene before fit this one: hardly anything is new, nor is the
// whole elsewhere, or of another size.
bool CudaDetector::isAlike(const ColdStart& start, const DeviceScene::Change& change,
                           const Options& options) const {
  if (kNewShare * change.more_triangles > scene_.triangleCount()) return false;
  const double ratio = start.scale.scale / scale_.scale;
  const Vec3d moved = scale_.applyExact(start.scale.origin);  // in halves of the scene's size
  const double most_moved = std::max({std::fabs(moved.x), std::fabs(moved.y), std::fabs(moved.z)});
  const std::size_t wanted =
      clusterCountFor(options.clusters, cluster_counts_, start.regular, sizes_.clusters);
  return ratio >= 0.5 && ratio <= 2 && most_moved < 0.25 &&
         std::max<std::size_t>(1, wanted) == sizes_.clusters;
}

// Prototypes from the seeds.
void CudaDetector::startCold(const ColdStart& start, const Options& options) {
  asked_clusters_ = options.clusters;
  scale_ = start.scale;
  const cudaStream_t stream = stream_.get();
  checkCuda(
      cudaMemcpyAsync(arrays_.clusters.prototypes.data(), start.seeds.data(),
                      start.seeds.size() * sizeof(start.seeds[0]), cudaMemcpyHostToDevice, stream),
      "cudaMemcpyAsync to the device");
  launchClusterStart(arrays_, stream);
  stream_.synchronise();  // the host's seeds go
  cycles_since_refresh_ = 0;
}

// Arrays of the sizes.
void CudaDetector::makeArrays() {
  if (memory_.isToGrow(sizes_)) {
    copies_.launch();  // they know where arrays were
    memory_.grow(sizes_, stream_.get());
  }
  arrays_.clusters.count = sizes_.clusters;
  arrays_.clusters.sample_count = std::min(sizes_.samples, scene_.triangleCount());
}

// Behind what is in the stream; `few`: no more than take little time.
void CudaDetector::fetchContacts(const Options& options, bool few) {
  const std::uint32_t most = few ? kMostListedLate : std::numeric_limits<std::uint32_t>::max();
  const bool swept = options.motion == Motion::kSwept;
  const BodyLengths any = scene_.anyLengths();
  const ContactFields fields{any.margins && !swept, options.geometry, options.first_times,
                             any.pads && swept};
  output_.fetch(arrays_, fields, std::min(listable(last_contacts_), most), most, result_.contacts,
                stream_.get());
}

// A scene that has outgrown its scale starts anew; one that has outgrown its clusters has new ones,
// from samples of the old ones if there are enough.
void CudaDetector::noteGrowth(const CycleCounters& counted, const Options& options) {
  constexpr std::uint64_t kSamplesEach = 4;
  const std::size_t wanted =
      clusterCountFor(options.clusters, cluster_counts_, counted.clustered, sizes_.clusters);
  wanted_clusters_ = options.clusters > 0
                         ? sizes_.clusters
                         : std::max<std::uint32_t>(1, static_cast<std::uint32_t>(wanted));
  const std::uint64_t samples = std::uint64_t{arrays_.clusters.sample_count} * counted.clustered;
  const bool few_samples = samples < kSamplesEach * wanted_clusters_ * scene_.triangleCount();
  const bool more_large = counted.large > 2 * large_at_start_ + 64 + counted.clustered / 64;
  cold_ = more_large || (wanted_clusters_ != sizes_.clusters && few_samples);
  sample_misled_ = cold_ && result_.started_cold;
}

namespace {

// The device loads each kernel when it runs for the first time in a process, which takes longer
// than a cycle: a scene as small as can be runs all that a cycle may need, once for each device.
void loadKernels(int device) {
  static std::mutex mutex;
  static std::set<int> loaded;
  const std::lock_guard<std::mutex> lock(mutex);
  if (loaded.count(device) > 0) return;
  Scene scene;
  scene.addBody("", {{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.1F}, {0, 1, 2, 1, 3, 2}});
  scene.addBody("", {{0.2F, 0.2F, -1, 0.2F, 0.3F, 1, 0.3F, 0.2F, 1}, {0, 1, 2}});
  scene.setPairEnabled(0, 0, true);
  scene.setPairEnabled(0, 1, true);
  scene.setEarlier(1, RigidTransform());
  Options options;
  options.clusters = 2;
  CudaSettings settings;
  settings.device = device;
  CudaDetector detector(settings);
  for (int i = 0; i < 3; ++i) detector.detect(scene, options);  // the third is a recorded one
  options.motion = Motion::kSwept;
  detector.detect(scene, options);
  loaded.insert(device);
}

}  // namespace

std::unique_ptr<ShareDetector> makeCudaShareDetector(const CudaSettings& settings) {
  requireUsable(settings.device);
  loadKernels(settings.device);
  return std::make_unique<CudaDetector>(settings);
}

std::unique_ptr<Detector> makeCudaDetector(const CudaSettings& settings) {
  return makeSharedDetector(settings, makeCudaShareDetector);
}

}  // namespace deformable_contact_monitor
