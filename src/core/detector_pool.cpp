#include "core/detector_pool.h"

#include <algorithm>
#include <iterator>
#include <list>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/bounds/bounded_cycle.h"
#include "core/bounds/radii.h"
#include "core/common/guarded_detector.h"
#include "core/common/scene_queries.h"

namespace deformable_contact_monitor {
namespace {

BackendFault faultOf(const std::runtime_error& error) {
  const auto* known = dynamic_cast<const BackendError*>(&error);
  return known == nullptr ? BackendFault::kTransient : known->fault();
}

// One backend's detectors, one for each set of enabled pairs and kind of motion.
class WarmDetectors {
 public:
  WarmDetectors(DetectorMaker make, std::size_t most, std::uint64_t most_bytes)
      : make_(std::move(make)), most_(most), most_bytes_(most_bytes) {}

  bool canBeMade() const { return make_ != nullptr; }
  bool empty() const { return all_.empty(); }

  void makeFirst() {
    if (all_.empty()) all_.push_back({{}, Motion::kInstant, 0, make_(), 0});
  }
  void clear() { all_.clear(); }
  void reset() {
    for (Warm& warm : all_) warm.detector->reset();
  }

  // Returns the detector that ran last. There must be one.
  Detector& last() const { return *all_.front().detector; }

  const DetectionResult& detect(const Scene& scene, const Options& options) {
    makeFirst();
    choose(scene, options.motion);
    Warm& warm = all_.front();
    if (warm.has_failed) {
      warm.detector = make_();
      warm.detector_bytes = 0;
      warm.has_failed = false;
    }
    try {
      const DetectionResult& result = warm.detector->detect(scene, options);
      // Memory never shrinks, but a cycle that is cut off at once does not count it.
      warm.detector_bytes = std::max(warm.detector_bytes, result.detector_bytes);
      return result;
    } catch (const std::runtime_error& error) {
      warm.has_failed = faultOf(error) == BackendFault::kTransient;
      throw;
    }
  }

 private:
  struct Warm {
    std::vector<std::pair<BodyId, BodyId>> pairs;
    Motion motion;
    std::uint64_t pairs_revision;  // of the last scene with these pairs; 0: it never ran
    std::unique_ptr<Detector> detector;
    std::uint64_t detector_bytes;
    // It may ask for the same memory again, so the next detect() makes another one.
    bool has_failed = false;
  };

  // Moves the detector of the scene's pairs to the front.
  void choose(const Scene& scene, Motion motion) {
    const Warm& last = all_.front();
    if (last.pairs_revision == scene.pairsRevision() && last.motion == motion) return;
    std::vector<std::pair<BodyId, BodyId>> pairs = scene.enabledPairs();
    auto found = std::find_if(all_.begin(), all_.end(), [&](const Warm& warm) {
      return warm.pairs_revision != 0 && warm.motion == motion && warm.pairs == pairs;
    });
    if (found == all_.end()) {
      found = forNewPairs();
      found->pairs = std::move(pairs);
      found->motion = motion;
    }
    found->pairs_revision = scene.pairsRevision();
    all_.splice(all_.begin(), all_, found);
  }

  // Returns a new detector, or the one that has been idle longest.
  std::list<Warm>::iterator forNewPairs() {
    std::uint64_t bytes = 0;
    for (const Warm& warm : all_) bytes += warm.detector_bytes;
    const bool first_is_free = all_.front().pairs_revision == 0;
    const bool is_full = all_.size() >= most_ || bytes >= most_bytes_;
    if (!first_is_free && !is_full) all_.push_back({{}, Motion::kInstant, 0, make_(), 0});
    return std::prev(all_.end());
  }

  DetectorMaker make_;
  std::size_t most_;
  std::uint64_t most_bytes_;
  std::list<Warm> all_;  // those that ran last come first
};

class DetectorPool : public Detector {
 public:
  explicit DetectorPool(PoolSettings settings)
      : settings_(std::move(settings)),
        device_(settings_.device, settings_.most_detectors, settings_.memory_bytes),
        cpu_(settings_.cpu, settings_.most_detectors, settings_.memory_bytes) {
    if (!settings_.changed) settings_.changed = [](const BackendState&) {};
    if (!device_.canBeMade()) {
      useCpu();
      return;
    }
    try {
      device_.makeFirst();
      running_ = &device_;
    } catch (const std::runtime_error& error) {
      if (!cpu_.canBeMade()) throw;
      recordFailure(error, 0);
    }
  }

  std::string backend() const override { return running_->last().backend(); }

  // The CPU can read the device's vertex memory too, so it is used even while the CPU runs.
  std::pmr::memory_resource& vertexMemory() override {
    return (device_.empty() ? *running_ : device_).last().vertexMemory();
  }

  void reset() override {
    device_.reset();
    cpu_.reset();
    if (bounded_) bounded_->forget();
  }

  void swapResult(DetectionResult& result) override {
    const bool is_bounded = running_ == &cpu_ && bounded_ && bounded_->ownsResult();
    if (is_bounded) {
      bounded_->swapResult(result);
    } else {
      running_->last().swapResult(result);
    }
  }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    if (device_.canBeMade() && mayUseDevice(scene)) {
      try {
        const DetectionResult& result = device_.detect(scene, options);
        running_ = &device_;
        recordSuccess();
        return result;
      } catch (const std::runtime_error& error) {
        if (!cpu_.canBeMade()) throw;
        recordFailure(error, trianglesThatTakePart(scene));
      }
    }
    useCpu();
    if (bounded_) return bounded_->detect(scene, options);
    return cpu_.detect(scene, options);
  }

 private:
  void useCpu() {
    running_ = &cpu_;
    if (!cpu_.empty()) return;
    cpu_.makeFirst();
    if (settings_.tilings == nullptr) return;
    const auto exact = [this](const Scene& scene, const Options& options) -> const auto& {
      return cpu_.detect(scene, options);
    };
    bounded_.emplace(exact, settings_.tilings, cpu_.last().vertexMemory());
  }

  bool mayUseDevice(const Scene& scene) const {
    if (state_.problem.empty()) return true;
    if (!state_.tried_again) return false;
    if (settings_.retry->now() >= retry_at_) return true;
    return state_.fault == BackendFault::kSceneTooLarge &&
           trianglesThatTakePart(scene) < too_large_;
  }

  // Before the retry time, success with a smaller scene does not mean that the scene that was too
  // large would work.
  void recordSuccess() {
    if (state_.problem.empty()) return;
    const SteadyTime now = settings_.retry->now();
    if (now < retry_at_) return;
    calm_at_ = now + wait_;
    state_ = BackendState();
    settings_.changed(state_);
  }

  void recordFailure(const std::runtime_error& error, std::uint64_t triangles) {
    useCpu();
    const BackendState before = state_;
    state_.problem = error.what();
    state_.fault = faultOf(error);
    const bool is_too_large = state_.fault == BackendFault::kSceneTooLarge;
    state_.tried_again =
        settings_.retry && (is_too_large || state_.fault == BackendFault::kTransient);
    // Other failures leave detectors in an unknown state, and their memory may be what is missing.
    if (!is_too_large) device_.clear();
    if (state_.tried_again) setRetryTime(!before.problem.empty());
    const bool was_too_large =
        !before.problem.empty() && before.fault == BackendFault::kSceneTooLarge;
    too_large_ = was_too_large ? std::min(too_large_, triangles) : triangles;
    if (state_.problem != before.problem || state_.fault != before.fault) {
      settings_.changed(state_);
    }
  }

  void setRetryTime(bool failed_before) {
    const SteadyTime now = settings_.retry->now();
    if (failed_before || now < calm_at_) {
      wait_ = std::min(2 * wait_, fromSeconds(settings_.retry->most_s));
    } else {
      wait_ = fromSeconds(settings_.retry->first_s);
    }
    retry_at_ = now + wait_;
  }

  PoolSettings settings_;
  WarmDetectors device_, cpu_;
  std::optional<BoundedCycle> bounded_;  // on cpu_; there once the CPU ran and has tilings
  WarmDetectors* running_ = nullptr;     // never empty

  // The device's state and what follows from it.
  BackendState state_;
  std::uint64_t too_large_ = 0;  // triangles of the smallest scene that was too large
  SteadyTime::duration wait_{};
  SteadyTime retry_at_;  // the device is not tried before, if it has a problem
  SteadyTime calm_at_;   // a failure before this time doubles the wait
};

}  // namespace

std::unique_ptr<Detector> makeDetectorPool(PoolSettings settings) {
  if (!settings.device && !settings.cpu) {
    throw std::invalid_argument(
        "a pool of detectors has neither a maker for a device nor for the CPU");
  }
  return guardAgainstForks(
      withRadiiAndPartMargins(std::make_unique<DetectorPool>(std::move(settings))),
      AfterFork::kWorks);
}

}  // namespace deformable_contact_monitor
