// Prints what it costs that objects take turns: cycles of a monitor with four cloths over a plate,
// all with one detector, and each set of pairs with its own (makeDetectorPool).
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/cuda_error.h"
#include "scenes.h"
#include "tools/common/run_tool.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kCloths = 4;
constexpr std::size_t kWarmUp = 10 * kCloths, kCycles = 50 * kCloths;

struct Turns {
  Scene scene;
  BodyId plate = 0;
  std::vector<BodyId> cloths;
};

// The first cloth has 2 n n triangles; the others as many, or each fewer than the one before.
Turns makeTurns(int n, bool of_one_size) {
  Turns turns;
  turns.plate = turns.scene.addBody("plate", clothGrid(60, 1, 0, 0.01F));
  for (std::size_t i = 0; i < kCloths; ++i) {
    const int squares = of_one_size ? n : n - 3 * static_cast<int>(i) * n / 20;
    turns.cloths.push_back(turns.scene.addBody("cloth", clothGrid(squares, 0.25F, 0.01F, 0.03F)));
  }
  return turns;
}

const DetectionResult& takeTurn(Turns& turns, std::size_t turn, Detector& detector) {
  const std::size_t who = turn % kCloths;
  for (std::size_t i = 0; i < kCloths; ++i) {
    turns.scene.setPairEnabled(turns.plate, turns.cloths[i], i == who);
  }
  RigidTransform pose;
  pose.translation[0] = 0.25 * static_cast<double>(who);
  pose.translation[1] = 0.2 * static_cast<double>(who);
  pose.translation[2] = 1e-5 * static_cast<double>(turn);
  turns.scene.setPose(turns.cloths[who], pose);
  return detector.detect(turns.scene, Options());
}

// Returns whether the contacts equal those of `reference`.
bool printRow(const std::string& name, Turns turns, Detector& detector, Detector& reference) {
  std::vector<double> round_trip_ms;
  std::size_t cold_starts = 0;
  for (std::size_t turn = 0; turn < kWarmUp + kCycles; ++turn) {
    const DetectionResult& result = takeTurn(turns, turn, detector);
    if (turn < kWarmUp) continue;
    round_trip_ms.push_back(result.round_trip_ms);
    cold_starts += result.started_cold ? 1 : 0;
  }
  const std::vector<TrianglePair> found = takeTurn(turns, kCycles, detector).contacts;
  const bool equal = found == takeTurn(turns, kCycles, reference).contacts && !found.empty();
  std::printf("| %s | %zu | %.3f | %.3f | %zu of %zu | %s |\n", name.c_str(),
              turns.scene.body(turns.cloths[0]).mesh.triangleCount(), median(round_trip_ms),
              percentile(round_trip_ms, 0.95), cold_starts, kCycles, equal ? "equal" : "DIFFERENT");
  std::fflush(stdout);
  return equal;
}

bool printBackend(const std::string& backend,
                  const std::function<std::unique_ptr<Detector>()>& make, int n) {
  bool equal = true;
  for (const bool of_one_size : {true, false}) {
    const std::string name = backend + (of_one_size ? ", cloths of one size" : ", of four sizes");
    const Turns turns = makeTurns(n, of_one_size);
    const auto reference = makeCpuDetector();
    equal &= printRow(name + ", one detector", turns, *make(), *reference);
    PoolSettings settings;
    settings.cpu = make;
    equal &= printRow(name + ", by pairs", turns, *makeDetectorPool(settings), *reference);
  }
  return equal;
}

int run() {
  std::printf("| detectors | triangles of the first cloth | round trip ms | p95 | cold | sets |\n");
  std::printf("|---|---|---|---|---|---|\n");
  bool equal = true;
  for (const int n : {20, 70, 220}) {
    equal &= printBackend(
        "cpu", [] { return makeCpuDetector(); }, n);
    try {
      makeCudaDetector();
    } catch (const CudaError&) {
      continue;
    }
    equal &= printBackend(
        "cuda", [] { return makeCudaDetector(); }, n);
  }
  return equal ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main() {
  return deformable_contact_monitor::runTool("turns_benchmark", deformable_contact_monitor::run);
}
