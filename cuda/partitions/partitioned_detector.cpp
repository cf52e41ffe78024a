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

#include "core/common/stages.h"
#include "core/common/stopwatch.h"
#include "cuda/partitions/merged_partitions.h"
#include "cuda/partitions/partition_bounds.h"

namespace deformable_contact_monitor {
namespace {

// A thread that does one piece of work after the other, for one caller.
class Worker {
 public:
  Worker() : thread_([this] { loop(); }) {}
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    start(nullptr);
    thread_.join();
  }

  // `work` must not throw; to be waited for before the next.
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
  std::function<void()> work_;  // empty: the end
  bool busy_ = false;
  std::thread thread_;  // the last: it uses the others
};

// A device with its share of a cycle.
struct Sharer {
  int device;
  std::unique_ptr<ShareDetector> detector;
  const DetectionResult* result = nullptr;
  std::exception_ptr failure;

  void detect(const Scene& scene, const Options& options) {
    failure = nullptr;
    try {
      result = &detector->detect(scene, options);
    } catch (...) {
      failure = std::current_exception();
    }
  }
};

std::size_t trianglesThatTakePart(const Scene& scene) {
  std::size_t triangles = 0;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (scene.takesPart(id)) triangles += scene.body(id).mesh.triangleCount();
  }
  return triangles;
}

bool anyOnDevice(const Scene& scene) {
  return std::any_of(scene.bodies().begin(), scene.bodies().end(),
                     [](const Body& body) { return body.device_vertices.has_value(); });
}

// The failure of a device; any other goes to the caller.
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

class SharedDetector : public Detector {
 public:
  SharedDetector(std::vector<Sharer> sharers, const CudaSettings& settings)
      : sharers_(std::move(sharers)),
        from_triangles_(settings.shared_from_triangles),
        device_lost_(settings.device_lost),
        workers_(sharers_.size() - 1) {}

  std::string backend() const override { return sharers_.front().detector->backend(); }

  // Which all devices reach alike.
  std::pmr::memory_resource& vertexMemory() override {
    return sharers_.front().detector->vertexMemory();
  }

  void reset() override {
    for (Sharer& sharer : sharers_) sharer.detector->reset();
    bounds_ = ShareBounds();
  }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    requireValid(options);
    const Stopwatch watch{};
    const bool together = trianglesThatTakePart(scene) >= from_triangles_ && !anyOnDevice(scene);
    while (true) {
      const std::size_t count = together ? sharers_.size() : 1;
      if (runShares(scene, options, count)) {
        return count == 1 ? *sharers_.front().result : merge(scene, options, count, watch);
      }
    }
  }

 private:
  // False if a device failed; there is another one then.
  bool runShares(const Scene& scene, Options options, std::size_t count) {
    if (count > 1) {
      const std::vector<SceneShare>& shares = bounds_.cut(scene, count);
      for (std::size_t s = 0; s < count; ++s) sharers_[s].detector->setShare(shares[s]);
    } else {
      sharers_.front().detector->setShare(SceneShare());
    }
    const auto clusters = static_cast<std::size_t>(options.clusters);
    options.clusters = static_cast<int>((clusters + count - 1) / count);
    for (std::size_t s = 1; s < count; ++s) {
      workers_[s - 1].start([&, s] { sharers_[s].detect(scene, options); });
    }
    sharers_.front().detect(scene, options);
    for (std::size_t s = 1; s < count; ++s) workers_[s - 1].wait();
    return !dropFailed(count);
  }

  bool dropFailed(std::size_t count) {
    std::vector<BackendError> failures;
    for (std::size_t s = 0; s < count; ++s) {
      const Sharer& sharer = sharers_[s];
      if (sharer.failure) failures.push_back(failureOf(sharer.device, sharer.failure));
    }
    if (failures.empty()) return false;
    if (failures.size() == sharers_.size()) std::rethrow_exception(sharers_[0].failure);
    sharers_.erase(std::remove_if(sharers_.begin(), sharers_.end(),
                                  [](const Sharer& sharer) { return sharer.failure != nullptr; }),
                   sharers_.end());
    for (const BackendError& failure : failures) {
      if (device_lost_) device_lost_(failure);
    }
    return true;
  }

  const DetectionResult& merge(const Scene& scene, const Options& options, std::size_t count,
                               const Stopwatch& watch) {
    std::vector<const DetectionResult*> shares;
    std::vector<double> took_ms;
    for (std::size_t s = 0; s < count; ++s) {
      shares.push_back(sharers_[s].result);
      took_ms.push_back(sharers_[s].result->detect_ms);
    }
    result_.begin(scene, options, isGuaranteed(options));
    const Stopwatch merging{};
    mergeShares(shares, result_);
    if (!result_.started_cold && !result_.cut_off) bounds_.note(took_ms);
    for (auto& [name, ms] : result_.stages_ms) {
      if (name == kStageNames[static_cast<int>(Stage::kOutput)]) ms += merging.elapsedMs();
    }
    result_.round_trip_ms = watch.elapsedMs();
    return result_;
  }

  std::vector<Sharer> sharers_;  // at least one; what failed is gone
  const std::size_t from_triangles_;
  const std::function<void(const BackendError&)> device_lost_;
  std::vector<Worker> workers_;  // beside the caller's thread
  ShareBounds bounds_;
  DetectionResult result_;
};

}  // namespace

std::unique_ptr<Detector> makeSharedDetector(
    const CudaSettings& settings,
    const std::function<std::unique_ptr<ShareDetector>(const CudaSettings&)>& make) {
  const std::vector<int> devices =
      settings.devices.empty() ? std::vector<int>{settings.device} : settings.devices;
  std::vector<Sharer> sharers;
  std::vector<BackendError> failures;
  std::exception_ptr last;
  for (const int device : devices) {
    CudaSettings its = settings;
    its.device = device;
    its.devices.clear();
    try {
      sharers.push_back({device, make(its), nullptr, nullptr});
    } catch (const std::runtime_error&) {
      last = std::current_exception();
      failures.push_back(failureOf(device, last));
    }
  }
  if (sharers.empty()) std::rethrow_exception(last);
  for (const BackendError& failure : failures) {
    if (settings.device_lost) settings.device_lost(failure);
  }
  if (sharers.size() == 1) return std::move(sharers.front().detector);
  return std::make_unique<SharedDetector>(std::move(sharers), settings);
}

}  // namespace deformable_contact_monitor
