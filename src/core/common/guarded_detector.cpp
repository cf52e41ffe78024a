#include "core/common/guarded_detector.h"

#include <utility>

#include "core/backend_error.h"
#include "core/common/forks.h"

namespace deformable_contact_monitor {
namespace {

class GuardedDetector : public Detector {
 public:
  GuardedDetector(std::unique_ptr<Detector> detector, AfterFork after_fork)
      : detector_(std::move(detector)), backend_(detector_->backend()) {
    if (after_fork == AfterFork::kIsUnavailable) made_.set();
  }

  // A lost detector stays as it is: its destructor could wait for ever for threads and devices that
  // are gone.
  ~GuardedDetector() override {
    if (isLost()) static_cast<void>(detector_.release());
  }

  std::string backend() const override { return isLost() ? backend_ : detector_->backend(); }

  std::pmr::memory_resource& vertexMemory() override {
    return isLost() ? Detector::vertexMemory() : detector_->vertexMemory();
  }

  void reset() override {
    if (!isLost()) detector_->reset();
  }

  void swapResult(DetectionResult& result) override {
    requireUsable();
    detector_->swapResult(result);
  }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    requireUsable();
    // Is cleared also if detect() throws.
    struct Running {
      ProcessMark& mark;
      ~Running() { mark.clear(); }
    } const running{runs_};
    runs_.set();
    return detector_->detect(scene, options);
  }

 private:
  bool isLost() const { return made_.isInherited() || runs_.isInherited(); }

  void requireUsable() const {
    if (made_.isInherited()) {
      throw BackendError(BackendFault::kUnavailable,
                         backend_ +
                             " cannot be used in a process that was forked after it had been used "
                             "(start processes by exec, or by multiprocessing's 'spawn')");
    }
    if (runs_.isInherited()) {
      throw BackendError(BackendFault::kUnavailable,
                         "this process was forked while another thread was in this detector's "
                         "detect(): make another detector");
    }
  }

  std::unique_ptr<Detector> detector_;
  const std::string backend_;
  ProcessMark made_;  // set if the detector works only in the process that made it
  ProcessMark runs_;  // set during detect()
};

}  // namespace

std::unique_ptr<Detector> guardAgainstForks(std::unique_ptr<Detector> detector,
                                            AfterFork after_fork) {
  return std::make_unique<GuardedDetector>(std::move(detector), after_fork);
}

}  // namespace deformable_contact_monitor
