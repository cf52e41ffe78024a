#include "cuda/detector_choice.h"

#include <chrono>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "cuda/cuda_detector.h"
#include "cuda/cuda_state_checker.h"

namespace deformable_contact_monitor {
namespace {

// Combines two kinds of news into what `changed` is called with: the state of the pool, and devices
// of several that were lost. Each warm detector loses the same device by itself, but it is reported
// once. While such a device is missing, the state that follows a recovery is "partly".
class BackendNews {
 public:
  explicit BackendNews(std::function<void(const BackendState&)> changed)
      : changed_(std::move(changed)) {}

  void report(const BackendState& state) {
    // After any other fault all detectors are made again, and may lose devices again.
    const bool all_are_made_anew = state.fault != BackendFault::kSceneTooLarge;
    if (!state.problem.empty() && all_are_made_anew) lost_.clear();
    changed_(state.problem.empty() && !lost_.empty() ? last_lost_ : state);
  }

  void reportLost(const BackendError& error) {
    if (!lost_.insert(error.what()).second) return;
    last_lost_.problem = error.what();
    last_lost_.fault = error.fault();
    last_lost_.partly = true;
    changed_(last_lost_);
  }

 private:
  const std::function<void(const BackendState&)> changed_;
  std::set<std::string> lost_;  // what() of each
  BackendState last_lost_;
};

// Checks states on CUDA, and on the CPU where CUDA fails.
class ChosenStateChecker : public StateChecker {
 public:
  ChosenStateChecker(bool tries_again, const CudaSettings& settings,
                     std::function<void(const BackendState&)> changed)
      : tries_again_(tries_again), settings_(settings), changed_(std::move(changed)) {}

  std::string backend() const override { return cuda_ ? "cuda" : "cpu"; }
  void reset() override {
    if (cuda_) cuda_->reset();
    if (cpu_) cpu_->reset();
  }

  const StateResults& check(const Scene& scene, const StateBatch& batch,
                            const StateOptions& options) override {
    if (tryCuda()) {
      try {
        return cuda_->check(scene, batch, options);
      } catch (const BackendError& error) {
        if (error.fault() != BackendFault::kSceneTooLarge) lose(error);
      }
    }
    if (!cpu_) cpu_ = makeCpuStateChecker();
    return cpu_->check(scene, batch, options);
  }

  // Makes the checker on CUDA, if none works and it is time. Returns whether one works.
  bool tryCuda() {
    if (cuda_) return true;
    const auto now = std::chrono::steady_clock::now();
    if (was_lost_ && (!tries_again_ || now < again_)) return false;
    try {
      cuda_ = makeCudaStateChecker(settings_);
    } catch (const BackendError& error) {
      lose(error);
      return false;
    }
    if (was_lost_ && changed_) changed_(BackendState());
    was_lost_ = false;
    return true;
  }

 private:
  void lose(const BackendError& error) {
    const bool is_news = !was_lost_;
    was_lost_ = true;
    again_ = std::chrono::steady_clock::now() + std::chrono::seconds(1);
    cuda_.reset();
    if (is_news && changed_) changed_({error.what(), error.fault(), tries_again_, false});
  }

  const bool tries_again_;
  const CudaSettings settings_;
  const std::function<void(const BackendState&)> changed_;
  std::unique_ptr<StateChecker> cuda_, cpu_;
  bool was_lost_ = false;
  std::chrono::steady_clock::time_point again_;
};

}  // namespace

std::unique_ptr<Detector> makeDetector(BackendChoice choice, WithoutCuda without_cuda,
                                       const CudaSettings& settings,
                                       const std::function<void(const BackendState&)>& changed,
                                       const std::shared_ptr<TilingCache>& tilings) {
  PoolSettings pool;
  pool.memory_bytes = settings.memory_limit_bytes;
  pool.tilings = tilings;
  const bool is_cuda_alone = choice == BackendChoice::kCuda && without_cuda == WithoutCuda::kRefuse;
  if (!is_cuda_alone) {
    CpuSettings cpu;
    cpu.memory_limit_bytes = settings.memory_limit_bytes;
    cpu.tilings = tilings ? tilings : std::make_shared<TilingCache>();
    pool.cpu = cpuDetectorMaker(cpu);
  }
  if (choice != BackendChoice::kCpu) {
    CudaSettings cuda = settings;
    if (changed) {
      const auto news = std::make_shared<BackendNews>(changed);
      pool.changed = [news](const BackendState& state) { news->report(state); };
      cuda.device_lost = [news](const BackendError& error) { news->reportLost(error); };
    }
    pool.device = [cuda] { return makeCudaDetector(cuda); };
  }
  if (without_cuda == WithoutCuda::kTryAgain) pool.retry.emplace();
  return makeDetectorPool(std::move(pool));
}

std::unique_ptr<StateChecker> makeStateChecker(
    BackendChoice choice, WithoutCuda without_cuda, const CudaSettings& settings,
    const std::function<void(const BackendState&)>& changed) {
  if (choice == BackendChoice::kCpu) return makeCpuStateChecker();
  if (choice == BackendChoice::kCuda && without_cuda == WithoutCuda::kRefuse) {
    return makeCudaStateChecker(settings);
  }
  const bool tries_again = without_cuda == WithoutCuda::kTryAgain;
  auto checker = std::make_unique<ChosenStateChecker>(tries_again, settings, changed);
  checker->tryCuda();
  return checker;
}

}  // namespace deformable_contact_monitor
