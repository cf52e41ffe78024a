#include "core/fallback_detector.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "core/steady_time.h"

namespace deformable_contact_monitor {
namespace {

std::uint64_t trianglesThatTakePart(const Scene& scene) {
  std::uint64_t triangles = 0;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (scene.takesPart(id)) triangles += scene.body(id).mesh.triangleCount();
  }
  return triangles;
}

BackendFault faultOf(const std::runtime_error& error) {
  const auto* known = dynamic_cast<const BackendError*>(&error);
  return known == nullptr ? BackendFault::kTransient : known->fault();
}

class FallbackDetector : public Detector {
 public:
  FallbackDetector(DetectorMaker first, DetectorMaker second,
                   std::function<void(const BackendState&)> changed,
                   std::optional<RetryTimes> retry)
      : make_first_(std::move(first)),
        make_second_(std::move(second)),
        changed_(changed ? std::move(changed) : [](const BackendState&) {}),
        retry_(std::move(retry)) {
    try {
      first_ = make_first_();
      running_ = first_.get();
    } catch (const std::runtime_error& error) {
      noteFailure(error, 0);
    }
  }

  std::string backend() const override { return running_->backend(); }

  // Of the first, where there is one: others can read it too.
  std::pmr::memory_resource& vertexMemory() override {
    return first_ ? first_->vertexMemory() : running_->vertexMemory();
  }

  void reset() override {
    if (first_) first_->reset();
    if (second_) second_->reset();
  }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    if (mayTryFirst(scene)) {
      try {
        if (!first_) first_ = make_first_();
        const DetectionResult& result = first_->detect(scene, options);
        running_ = first_.get();
        noteSuccess();
        return result;
      } catch (const std::runtime_error& error) {
        noteFailure(error, trianglesThatTakePart(scene));
      }
    }
    running_ = second_.get();
    return second_->detect(scene, options);
  }

 private:
  bool mayTryFirst(const Scene& scene) const {
    if (state_.problem.empty()) return true;
    if (!state_.tried_again) return false;
    if (retry_->now() >= retry_at_) return true;
    return state_.fault == BackendFault::kSceneTooLarge &&
           trianglesThatTakePart(scene) < too_large_;
  }

  // That a smaller scene worked says nothing of the one that was too large.
  void noteSuccess() {
    if (state_.problem.empty()) return;
    const SteadyTime now = retry_->now();
    if (now < retry_at_) return;
    calm_at_ = now + wait_;
    state_ = BackendState();
    changed_(state_);
  }

  void noteFailure(const std::runtime_error& error, std::uint64_t triangles) {
    if (!second_) second_ = make_second_();
    running_ = second_.get();
    const BackendState before = state_;
    state_.problem = error.what();
    state_.fault = faultOf(error);
    const bool too_large = state_.fault == BackendFault::kSceneTooLarge;
    state_.tried_again = retry_ && (too_large || state_.fault == BackendFault::kTransient);
    if (!too_large) first_.reset();  // with its memory, and whatever state the failure left it in
    if (state_.tried_again) setRetryTime(!before.problem.empty());
    const bool was_too_large =
        !before.problem.empty() && before.fault == BackendFault::kSceneTooLarge;
    too_large_ = was_too_large ? std::min(too_large_, triangles) : triangles;
    if (state_.problem != before.problem || state_.fault != before.fault) changed_(state_);
  }

  void setRetryTime(bool failed_before) {
    const SteadyTime now = retry_->now();
    const bool again = failed_before || now < calm_at_;
    wait_ = again ? std::min(2 * wait_, fromSeconds(retry_->most_s)) : fromSeconds(retry_->first_s);
    retry_at_ = now + wait_;
  }

  const DetectorMaker make_first_, make_second_;
  const std::function<void(const BackendState&)> changed_;
  const std::optional<RetryTimes> retry_;
  std::unique_ptr<Detector> first_, second_;
  Detector* running_ = nullptr;
  BackendState state_;
  std::uint64_t too_large_ = 0;  // triangles; of a state of kSceneTooLarge
  SteadyTime::duration wait_{};
  SteadyTime retry_at_, calm_at_;
};

}  // namespace

std::unique_ptr<Detector> makeFallbackDetector(DetectorMaker first, DetectorMaker second,
                                               std::function<void(const BackendState&)> changed,
                                               std::optional<RetryTimes> retry) {
  return std::make_unique<FallbackDetector>(std::move(first), std::move(second), std::move(changed),
                                            std::move(retry));
}

}  // namespace deformable_contact_monitor
