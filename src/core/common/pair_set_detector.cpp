#include "core/common/pair_set_detector.h"

#include <algorithm>
#include <iterator>
#include <list>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {
namespace {

class PairSetDetector : public Detector {
 public:
  PairSetDetector(std::function<std::unique_ptr<Detector>()> make, const PairSetLimits& limits)
      : make_(std::move(make)), limits_(limits) {
    kept_.push_back({{}, Motion::kInstant, 0, make_(), 0});  // what cannot be made says so at once
  }

  std::string backend() const override { return kept_.front().detector->backend(); }

  std::pmr::memory_resource& vertexMemory() override {
    return kept_.front().detector->vertexMemory();
  }

  void reset() override {
    for (Kept& kept : kept_) kept.detector->reset();
  }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    choose(scene, options.motion);
    const DetectionResult& result = kept_.front().detector->detect(scene, options);
    // It never shrinks, and a cycle that is cut off at once does not count it.
    kept_.front().memory_bytes = std::max(kept_.front().memory_bytes, result.memory_bytes);
    return result;
  }

 private:
  struct Kept {
    std::vector<std::pair<BodyId, BodyId>> pairs;
    Motion motion;
    std::uint64_t pairs_revision;  // Scene::pairsRevision() of the last scene with them; 0: none
    std::unique_ptr<Detector> detector;
    std::uint64_t memory_bytes;
  };

  // Brings the scene's own to the front.
  void choose(const Scene& scene, Motion motion) {
    const Kept& last = kept_.front();
    if (last.pairs_revision == scene.pairsRevision() && last.motion == motion) return;
    std::vector<std::pair<BodyId, BodyId>> pairs = scene.enabledPairs();
    auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) {
      return kept.pairs_revision != 0 && kept.motion == motion && kept.pairs == pairs;
    });
    if (found == kept_.end()) {
      found = forNewSet();
      found->pairs = std::move(pairs);
      found->motion = motion;
    }
    found->pairs_revision = scene.pairsRevision();
    kept_.splice(kept_.begin(), kept_, found);
  }

  std::list<Kept>::iterator forNewSet() {
    std::uint64_t bytes = 0;
    for (const Kept& kept : kept_) bytes += kept.memory_bytes;
    const bool first_is_free = kept_.front().pairs_revision == 0;
    const bool full = kept_.size() >= limits_.detectors || bytes >= limits_.memory_bytes;
    if (!first_is_free && !full) kept_.push_back({{}, Motion::kInstant, 0, make_(), 0});
    return std::prev(kept_.end());
  }

  const std::function<std::unique_ptr<Detector>()> make_;
  const PairSetLimits limits_;
  std::list<Kept> kept_;  // at least one; those that ran last come first
};

}  // namespace

std::unique_ptr<Detector> makePairSetDetector(std::function<std::unique_ptr<Detector>()> make,
                                              const PairSetLimits& limits) {
  return std::make_unique<PairSetDetector>(std::move(make), limits);
}

}  // namespace deformable_contact_monitor
