#include "core/common/cycle_limit.h"
#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"
#include "core/cpu_detector.h"
#include "core/state_checker.h"
#include "core/states/state_input.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

// Decides states one after the other, each by a detection.
class CpuStateChecker : public StateChecker {
 public:
  std::string backend() const override { return "cpu"; }
  void reset() override { detector_->reset(); }

  const StateResults& check(const Scene& scene, const StateBatch& batch,
                            const StateOptions& options) override {
    const Stopwatch watch;
    requireValid(scene, batch);
    results_ = StateResults();
    results_.states.resize(batch.count);
    Scene copy = scene;
    for (const auto& [a, b] : scene.enabledPairs()) copy.setPairEnabled(a, b, false);
    const std::vector<IdPair> pairs = pairsOfStates(scene, batch);
    for (const auto& [a, b] : pairs) copy.setPairEnabled(a, b, true);
    requireHostVertices(copy, backend());
    results_.rejected = rejectedOfStates(scene, pairs);
    const CycleLimit limit(options.limits);
    for (std::size_t state = 0; state < batch.count && !results_.cut_off; ++state) {
      decide(batch, options, limit, pairs, state, &copy);
    }
    results_.check_ms = watch.elapsedMs();
    return results_;
  }

 private:
  void decide(const StateBatch& batch, const StateOptions& options, const CycleLimit& limit,
              const std::vector<IdPair>& pairs, std::size_t state, Scene* scene) {
    if (limit.over()) {
      results_.cut_off = true;
      results_.cut_off_because = limit.why();
      return;
    }
    const RigidTransform* const poses = batch.poses + state * batch.moved.size();
    for (std::size_t i = 0; i < batch.moved.size(); ++i) {
      if (!isFinite(poses[i])) return;
      scene->setPose(batch.moved[i], poses[i]);
    }
    Options settings;
    settings.nearest = true;
    settings.threads = options.threads;
    settings.limits = options.limits;
    const DetectionResult& result = detector_->detect(*scene, settings);
    if (result.cut_off) {
      results_.cut_off = true;
      results_.cut_off_because = result.cut_off_because;
      return;
    }
    StateAnswer& answer = results_.states[state];
    const auto touching = result.touchingBodies();
    for (const NearestPair& pair : result.nearest) {
      const bool is_first = &pair == result.nearest.data();
      if (is_first || pair.distance_m < answer.nearest.distance_m) answer.nearest = pair;
    }
    bool leaves = false;
    for (const auto& [a, b] : pairs) {
      leaves = leaves || leavesFloats(scene->body(a), scene->body(a).pose) ||
               leavesFloats(scene->body(b), scene->body(b).pose);
    }
    if (!touching.empty()) {
      answer.decision = PairDecision::kContact;
    } else if (!leaves) {
      const bool near = options.nearest && !result.nearest.empty();
      answer.decision = near ? PairDecision::kNear : PairDecision::kNone;
    }
    if (!options.nearest || answer.decision == PairDecision::kOpen) answer.nearest = NearestPair();
    for (const auto& [a, b] : touching) {
      if (options.pairs) results_.pairs.push_back({static_cast<std::uint32_t>(state), a, b});
    }
  }

  std::unique_ptr<Detector> detector_ = makeCpuDetector();
  StateResults results_;
};

}  // namespace

std::unique_ptr<StateChecker> makeCpuStateChecker() { return std::make_unique<CpuStateChecker>(); }

}  // namespace deformable_contact_monitor
