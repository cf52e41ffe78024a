// Prints what a random state of the Panda beside a cloth costs, by batch size, beside FCL and
// spheres; or compares states with single detections, to the bit.
//
//     states_benchmark [SQUARES [STATES [MARGIN_M]]]      a cloth of 2 SQUARES^2 triangles (87)
//     states_benchmark --check STATES [SQUARES [MARGIN_M]]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "core/state_checker.h"
#include "cuda/cuda_state_checker.h"
#include "robot_scenes.h"
#include "tools/measure_trade/state_measurement.h"

namespace deformable_contact_monitor {
namespace {

SceneStates statesOf(int squares, std::size_t count, float margin_m, std::uint32_t seed) {
  PandaStates panda = pandaStates(count, seed);
  SceneStates states{pandaAndCloth(squares), std::move(panda.moved), std::move(panda.poses)};
  states.scene.setMargin(0, margin_m);
  return states;
}

// Returns null where there is no device.
std::unique_ptr<StateChecker> cudaCheckerOrNull() {
  try {
    return makeCudaStateChecker();
  } catch (const BackendError&) {
    return nullptr;
  }
}

void print(int squares, std::size_t count, float margin_m) {
  const SceneStates states = statesOf(squares, count, margin_m, 1);
  const std::vector<bool> touches = exactTouches(states);
  std::printf("%zu triangles of cloth, %zu in all; %zu states, %zu of them touch; margin %g m\n",
              states.scene.body(0).mesh.triangleCount(), states.scene.triangleCount(), count,
              static_cast<std::size_t>(std::count(touches.begin(), touches.end(), true)), margin_m);
  std::vector<StateMeasurement> all;
  const auto add = [&](StateWay way, std::size_t batch) {
    if (way.checker != nullptr) all.push_back(measureStates(states, touches, batch, 5, &way));
  };
  for (const bool nearest : {false, true}) {
    for (std::size_t batch = 1; batch <= count; batch *= 10) {
      add({"cpu", makeCpuStateChecker(), nearest, 1}, batch);
    }
  }
  for (const bool nearest : {false, true}) {
    for (std::size_t batch = 1; batch <= count; batch *= 10) {
      add({"cuda", cudaCheckerOrNull(), nearest, 1}, batch);
    }
  }
  add({"fcl", makeFclStateChecker(), false, 1}, count);
  for (const std::size_t spheres : {4, 8, 16}) {
    for (const SphereSize size : {SphereSize::kCovering, SphereSize::kMean}) {
      auto checker = makeSphereStateChecker(spheres, size);
      const std::string name = checker->backend() + " " + std::to_string(spheres);
      add({name, std::move(checker), false, 1}, count);
    }
  }
  std::fputs(statesText(all).c_str(), stdout);
}

bool isSame(const SceneStates& states, std::size_t state, const StateAnswer& answer,
            Detector* detector, Scene* posed) {
  for (std::size_t i = 0; i < states.moved.size(); ++i) {
    posed->setPose(states.moved[i], states.poses[state * states.moved.size() + i]);
  }
  Options options;
  options.nearest = true;
  const DetectionResult& result = detector->detect(*posed, options);
  const NearestPair* least = nullptr;
  for (const NearestPair& pair : result.nearest) {
    if (least == nullptr || pair.distance_m < least->distance_m) least = &pair;
  }
  PairDecision decision = PairDecision::kNone;
  if (least != nullptr) decision = PairDecision::kNear;
  if (!result.contacts.empty()) decision = PairDecision::kContact;
  return answer.decision == decision && (least == nullptr || answer.nearest == *least);
}

// Returns how many states differ from single detections, on CUDA where there is a device.
std::size_t compare(std::size_t count, int squares, float margin_m) {
  constexpr std::size_t kBatch = 1000;
  auto checker = cudaCheckerOrNull();
  if (!checker) checker = makeCpuStateChecker();
  const auto detector = makeCpuDetector();
  StateOptions options;
  options.nearest = true;
  std::size_t different = 0, kinds[4] = {0, 0, 0, 0};
  for (std::size_t first = 0; first < count; first += kBatch) {
    const SceneStates states =
        statesOf(squares, kBatch, margin_m, static_cast<std::uint32_t>(first));
    Scene posed = states.scene;
    const StateResults& results = checker->check(states.scene, states.batch(0, kBatch), options);
    for (std::size_t i = 0; i < kBatch; ++i) {
      ++kinds[static_cast<int>(results.states[i].decision)];
      if (!isSame(states, i, results.states[i], detector.get(), &posed)) ++different;
    }
  }
  std::printf("%s: %zu none, %zu near, %zu contact, %zu open; %zu differ from single detections\n",
              checker->backend().c_str(), kinds[0], kinds[1], kinds[2], kinds[3], different);
  return different;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  const auto number = [&](int i, double otherwise) {
    return i < argc ? std::atof(argv[i]) : otherwise;
  };
  if (argc > 2 && std::strcmp(argv[1], "--check") == 0) {
    const auto count = static_cast<std::size_t>(number(2, 0));
    return dcm::compare(count, static_cast<int>(number(3, 87)),
                        static_cast<float>(number(4, 0.1))) == 0
               ? 0
               : 1;
  }
  dcm::print(static_cast<int>(number(1, 87)), static_cast<std::size_t>(number(2, 1000)),
             static_cast<float>(number(3, 0.1)));
}
