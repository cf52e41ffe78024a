// States decided by single detections, and random states.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <ostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/common/posed_body.h"
#include "core/state_checker.h"
#include "cuda/cuda_state_checker.h"
#include "detector_suite.h"

namespace deformable_contact_monitor {

struct StateBackend {
  const char* name;
  std::unique_ptr<StateChecker> (*make)();
};

inline std::ostream& operator<<(std::ostream& out, const StateBackend& backend) {
  return out << backend.name;
}

// Returns the backends that users get. CUDA is among them if there is a device.
inline std::vector<StateBackend> stateBackends() {
  std::vector<StateBackend> backends = {{"cpu", makeCpuStateChecker}};
  try {
    makeCudaStateChecker();
    backends.push_back({"cuda", [] { return makeCudaStateChecker(); }});
  } catch (const CudaError&) {
    if (isCudaRequired()) throw;
  }
  return backends;
}

inline std::string stateBackendName(const ::testing::TestParamInfo<StateBackend>& info) {
  return info.param.name;
}

inline std::ostream& operator<<(std::ostream& out, const TouchingBodies& pair) {
  return out << "state " << pair.state << ": " << pair.body_a << " " << pair.body_b;
}

inline bool operator==(const StateAnswer& x, const StateAnswer& y) {
  return x.decision == y.decision && x.nearest == y.nearest;
}

inline std::ostream& operator<<(std::ostream& out, const StateAnswer& answer) {
  const NearestPair& n = answer.nearest;
  return out << toString(answer.decision) << ", " << n.pair << " at " << std::hexfloat
             << n.distance_m << std::defaultfloat;
}

// Owns the poses of a batch.
struct States {
  std::vector<BodyId> moved;
  std::vector<RigidTransform> poses;

  StateBatch batch() const {
    return {moved, moved.empty() ? 0 : poses.size() / moved.size(), poses.data()};
  }
};

// Returns the scene in which only the pairs that depend on the states are enabled.
inline Scene onlyPairsOf(const StateBatch& batch, Scene scene) {
  for (const auto& [a, b] : scene.enabledPairs()) {
    const auto isMoved = [&batch](BodyId id) {
      return std::count(batch.moved.begin(), batch.moved.end(), id) > 0;
    };
    if (a == b || (!isMoved(a) && !isMoved(b))) scene.setPairEnabled(a, b, false);
  }
  return scene;
}

// Returns whether a pose makes vertices of a triangle infinite that were received finite.
inline bool anyLeavesFloats(const Scene& scene) {
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const PosedBody body(scene.body(id));
    for (std::uint32_t t = 0; t < scene.body(id).mesh.triangleCount(); ++t) {
      if (isFinite(body.received(t)) && !isFinite(body.triangle(t))) return true;
    }
  }
  return false;
}

// Decides each state by a detection of its own.
class SingleDetections {
 public:
  explicit SingleDetections(std::unique_ptr<Detector> detector) : detector_(std::move(detector)) {}

  StateResults check(const Scene& scene, const StateBatch& batch, const StateOptions& options) {
    StateResults results;
    results.states.resize(batch.count);
    Scene posed = onlyPairsOf(batch, scene);
    for (std::uint32_t state = 0; state < batch.count; ++state) {
      if (setPoses(batch, state, &posed)) decide(posed, state, options, &results);
    }
    return results;
  }

 private:
  static bool setPoses(const StateBatch& batch, std::uint32_t state, Scene* scene) {
    try {
      for (std::size_t i = 0; i < batch.moved.size(); ++i) {
        scene->setPose(batch.moved[i], batch.poses[state * batch.moved.size() + i]);
      }
    } catch (const std::invalid_argument&) {
      return false;
    }
    return true;
  }

  void decide(const Scene& scene, std::uint32_t state, const StateOptions& options,
              StateResults* results) {
    Options search;
    search.nearest = true;
    search.threads = options.threads;
    const DetectionResult& result = detector_->detect(scene, search);
    StateAnswer& answer = results->states[state];
    const auto touching = result.touchingBodies();
    if (touching.empty() && anyLeavesFloats(scene)) return;
    if (options.pairs) {
      for (const auto& [a, b] : touching) results->pairs.push_back({state, a, b});
    }
    answer.decision = touching.empty() ? PairDecision::kNone : PairDecision::kContact;
    if (!options.nearest || result.nearest.empty()) return;
    if (touching.empty()) answer.decision = PairDecision::kNear;
    answer.nearest = result.nearest[0];
    for (const NearestPair& pair : result.nearest) {
      if (pair.distance_m < answer.nearest.distance_m) answer.nearest = pair;
    }
  }

  std::unique_ptr<Detector> detector_;
};

class StatesTest : public ::testing::TestWithParam<StateBackend> {
 protected:
  // Expects what single detections find, asked in each way, of a checker with a past and of one
  // without. Returns what they find of each state.
  std::vector<StateAnswer> expectSame(const Scene& scene, const States& states) {
    StateOptions options;
    std::vector<StateAnswer> answers;
    for (const bool pairs : {true, false}) {
      for (const bool nearest : {false, true}) {
        options.pairs = pairs;
        options.nearest = nearest;
        options.threads = pairs ? 1 : 3;
        SCOPED_TRACE(std::string(pairs ? "pairs" : "") + (nearest ? " nearest" : ""));
        const StateResults expected = single_.check(scene, states.batch(), options);
        const auto other = GetParam().make();
        for (StateChecker* checker : {checker_.get(), other.get()}) {
          const StateResults& results = checker->check(scene, states.batch(), options);
          EXPECT_EQ(expected.states, results.states);
          EXPECT_EQ(expected.pairs, results.pairs);
          EXPECT_FALSE(results.cut_off);
        }
        answers = expected.states;
      }
    }
    return answers;
  }

  std::unique_ptr<StateChecker> checker_ = GetParam().make();
  SingleDetections single_{makeBruteForceDetector()};
};

}  // namespace deformable_contact_monitor
