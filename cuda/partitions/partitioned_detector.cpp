// Runs several detectors, one for each device, on partitions of the same scene. The caller's thread
// works for the first device, and each other device has a thread of its own. A device that fails is
// dropped, and the cycle is repeated on the devices that are left.
#include "cuda/partitions/partitioned_detector.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/bounds/exact_distances.h"
#include "core/bounds/radii.h"
#include "core/common/guarded_detector.h"
#include "core/common/scene_queries.h"
#include "core/common/stages.h"
#include "core/common/stopwatch.h"
#include "cuda/device/own_process.h"
#include "cuda/partitions/merged_partitions.h"
#include "cuda/partitions/partition_bounds.h"

namespace deformable_contact_monitor {
namespace {

// A thread that runs one piece of work after the other, for one caller. The destructor waits until
// the thread has ended.
class Worker {
 public:
  Worker() : thread_([this] { loop(); }) {}
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    start(nullptr);
    thread_.join();
  }

  // Starts `work`, which must not throw. Call wait() before the next start().
  void start(std::function<void()> work) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      work_ = std::move(work);
      busy_ = true;
    }
    changed_.notify_all();
  }
  void wait() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return !busy_; });
  }

 private:
  void loop() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return busy_; });
      if (!work_) return;
      lock.unlock();
      work_();
      lock.lock();
      busy_ = false;
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::function<void()> work_;  // empty: the thread is to end
  bool busy_ = false;
  std::thread thread_;  // declared last, because it uses the other members
};

// One device with its detector, and the outcome of its last cycle: a result or a failure.
struct DevicePartition {
  int device;
  std::unique_ptr<PartitionDetector> detector;
  const DetectionResult* result = nullptr;
  std::exception_ptr failure;

  // Runs a cycle. Keeps an exception in `failure`, because it may run on another thread than the
  // caller's.
  void detect(const Scene& scene, const Options& options) {
    try {
      result = &detector->detect(scene, options);
    } catch (...) {
      failure = std::current_exception();
    }
  }
};

// Returns whether some body has its vertices on a device. Such a scene is not divided, because only
// one device may be able to read them.
bool anyOnDevice(const Scene& scene) {
  return std::any_of(scene.bodies().begin(), scene.bodies().end(),
                     [](const Body& body) { return body.device_vertices.has_value(); });
}

// Returns whether a device's search for nearest pairs was complete.
bool isSearched(const DetectionResult& result) {
  return !result.cut_off ||
         std::any_of(result.distances.begin(), result.distances.end(),
                     [](const BodyDistance& distance) { return distance.is_exact; });
}

// Returns the failure of a device as a BackendError that names the device. Rethrows failures that
// would occur on any other device too: wrong arguments, or a scene that is too large.
BackendError failureOf(int device, const std::exception_ptr& failure) {
  const std::string its = "CUDA device " + std::to_string(device) + ": ";
  try {
    std::rethrow_exception(failure);
  } catch (const BackendError& error) {
    if (error.fault() == BackendFault::kSceneTooLarge) throw;
    return {error.fault(), its + error.what()};
  } catch (const std::runtime_error& error) {
    return {BackendFault::kTransient, its + error.what()};
  }
}

// Implements Detector on all devices for large scenes, and on the first device alone for small
// ones. For one thread at a time.
class PartitionedDetector : public Detector {
 public:
  PartitionedDetector(std::vector<DevicePartition> partitions, const CudaSettings& settings)
      : partitions_(std::move(partitions)),
        from_triangles_(settings.shared_from_triangles),
        device_lost_(settings.device_lost),
        workers_(partitions_.size() - 1) {}

  std::string backend() const override { return partitions_.front().detector->backend(); }

  // Returns memory that all devices can access.
  std::pmr::memory_resource& vertexMemory() override {
    return partitions_.front().detector->vertexMemory();
  }

  void reset() override {
    for (DevicePartition& partition : partitions_) partition.detector->reset();
    bounds_ = PartitionBounds();
  }

  void swapResult(DetectionResult& result) override {
    if (is_merged_) {
      result_.swap(result);
    } else {
      partitions_.front().detector->swapResult(result);
    }
  }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    requireValid(options);
    const Stopwatch watch{};
    const bool in_partitions =
        trianglesThatTakePart(scene) >= from_triangles_ && !anyOnDevice(scene);
    while (true) {
      const std::size_t count = in_partitions ? partitions_.size() : 1;
      if (runPartitions(scene, options, count)) {
        is_merged_ = count > 1;
        return count == 1 ? *partitions_.front().result : merge(scene, options, count, watch);
      }
    }
  }

 private:
  // Detects on `count` devices at once. Returns false if a device failed; at least one device is
  // left then. Throws if no device is left.
  bool runPartitions(const Scene& scene, Options options, std::size_t count) {
    // A failure that was thrown left its device in use.
    for (DevicePartition& partition : partitions_) partition.failure = nullptr;
    if (count > 1) {
      const std::vector<ScenePartition>& partitions = bounds_.cut(scene, count);
      for (std::size_t s = 0; s < count; ++s) partitions_[s].detector->setPartition(partitions[s]);
    } else {
      partitions_.front().detector->setPartition(ScenePartition());
    }
    if (count > 1 && searchesNearest(options) && !options.nearest) {
      options.nearest = true;  // merge() makes the distances, and needs the first device's pairs
      options.near_pairs = true;
    }
    const auto clusters = static_cast<std::size_t>(options.clusters);
    options.clusters = static_cast<int>((clusters + count - 1) / count);
    for (std::size_t s = 1; s < count; ++s) {
      workers_[s - 1].start([&, s] { partitions_[s].detect(scene, options); });
    }
    partitions_.front().detect(scene, options);
    for (std::size_t s = 1; s < count; ++s) workers_[s - 1].wait();
    return !dropFailed(count);
  }

  // Removes the devices that failed and reports them to the user's callback. Returns whether there
  // were any. Rethrows the failure if all devices have failed.
  bool dropFailed(std::size_t count) {
    std::vector<BackendError> failures;
    for (std::size_t s = 0; s < count; ++s) {
      const DevicePartition& partition = partitions_[s];
      if (partition.failure) failures.push_back(failureOf(partition.device, partition.failure));
    }
    if (failures.empty()) return false;
    if (failures.size() == partitions_.size()) std::rethrow_exception(partitions_[0].failure);
    partitions_.erase(std::remove_if(partitions_.begin(), partitions_.end(),
                                     [](const DevicePartition& partition) {
                                       return partition.failure != nullptr;
                                     }),
                      partitions_.end());
    for (const BackendError& failure : failures) {
      if (device_lost_) device_lost_(failure);
    }
    return true;
  }

  // Merges the results of the first `count` devices. Times of a cold or cut-off cycle say nothing
  // about the next cycles, so the bounds do not learn from them.
  const DetectionResult& merge(const Scene& scene, const Options& options, std::size_t count,
                               const Stopwatch& watch) {
    std::vector<const DetectionResult*> partitions;
    std::vector<double> took_ms;
    for (std::size_t s = 0; s < count; ++s) {
      partitions.push_back(partitions_[s].result);
      took_ms.push_back(partitions_[s].result->detect_ms);
    }
    result_.begin(scene, options, isGuaranteed(options));
    const Stopwatch merging{};
    mergePartitions(partitions, result_);
    giveDistances(scene, options, isSearched(*partitions.front()), &result_);
    if (!result_.started_cold && !result_.cut_off) bounds_.note(took_ms);
    for (auto& [name, ms] : result_.stages_ms) {
      if (name == kStageNames[static_cast<int>(Stage::kOutput)]) ms += merging.elapsedMs();
    }
    result_.round_trip_ms = watch.elapsedMs();
    return result_;
  }

  std::vector<DevicePartition> partitions_;  // at least one; devices that failed are removed
  const std::size_t from_triangles_;
  const std::function<void(const BackendError&)> device_lost_;
  std::vector<Worker> workers_;  // for all devices but the first
  PartitionBounds bounds_;
  DetectionResult result_;
  // True if the last cycle's result is result_, and not that of the first device.
  bool is_merged_ = false;
};

}  // namespace

std::unique_ptr<Detector> makePartitionedDetector(
    const CudaSettings& settings,
    const std::function<std::unique_ptr<PartitionDetector>(const CudaSettings&)>& make) {
  requireOwnProcess();
  const std::vector<int> devices =
      settings.devices.empty() ? std::vector<int>{settings.device} : settings.devices;
  std::vector<DevicePartition> partitions;
  std::vector<BackendError> failures;
  std::exception_ptr last;
  for (const int device : devices) {
    CudaSettings its = settings;
    its.device = device;
    its.devices.clear();
    try {
      partitions.push_back({device, make(its), nullptr, nullptr});
    } catch (const std::runtime_error&) {
      last = std::current_exception();
      failures.push_back(failureOf(device, last));
    }
  }
  if (partitions.empty()) std::rethrow_exception(last);
  noteDeviceUse();
  for (const BackendError& failure : failures) {
    if (settings.device_lost) settings.device_lost(failure);
  }
  std::unique_ptr<Detector> detector;
  if (partitions.size() == 1) {
    detector = std::move(partitions.front().detector);
  } else {
    detector = std::make_unique<PartitionedDetector>(std::move(partitions), settings);
  }
  return guardAgainstForks(withRadiiAndPartMargins(std::move(detector)), AfterFork::kIsUnavailable);
}

}  // namespace deformable_contact_monitor
