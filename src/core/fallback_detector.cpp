#include "core/fallback_detector.h"

#include <stdexcept>
#include <utility>

namespace deformable_contact_monitor {
namespace {

class FallbackDetector : public Detector {
 public:
  FallbackDetector(const MakeDetector& first, MakeDetector second,
                   std::function<void(const std::string&)> warn)
      : second_(std::move(second)), warn_(std::move(warn)) {
    try {
      running_ = first();
      is_first_ = true;
    } catch (const std::runtime_error& error) {
      fallBack(error.what());
    }
  }

  std::string backend() const override { return running_->backend(); }
  void reset() override { running_->reset(); }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    if (is_first_) {
      try {
        return running_->detect(scene, options);
      } catch (const std::runtime_error& error) {
        fallBack(error.what());
      }
    }
    return running_->detect(scene, options);
  }

 private:
  void fallBack(const std::string& why) {
    running_ = second_();
    is_first_ = false;
    warn_(why);
  }

  MakeDetector second_;
  std::function<void(const std::string&)> warn_;
  std::unique_ptr<Detector> running_;
  bool is_first_ = false;
};

}  // namespace

std::unique_ptr<Detector> makeFallbackDetector(const MakeDetector& first, MakeDetector second,
                                               std::function<void(const std::string&)> warn) {
  return std::make_unique<FallbackDetector>(first, std::move(second), std::move(warn));
}

}  // namespace deformable_contact_monitor
