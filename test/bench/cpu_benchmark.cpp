// Prints a table of the CPU backend on real scenes: whole cycles and stages by the number of
// threads, moving input, medians and least times; every list of contacts is compared with the one
// of one thread.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "core/mesh_file.h"
#include "moving_scene.h"
#include "robot_scenes.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "stage_times.h"
#include "test_data.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

// FNV-1a over the list in its order.
std::uint64_t hashOf(const std::vector<TrianglePair>& contacts) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const TrianglePair& pair : contacts) {
    for (const std::uint32_t x : {pair.body_a, pair.triangle_a, pair.body_b, pair.triangle_b}) {
      hash = (hash ^ x) * 0x100000001b3U;
    }
  }
  return hash;
}

// One detector with its options, and what its cycles took.
struct Run {
  std::unique_ptr<Detector> detector = makeCpuDetector();
  Options options;
  std::vector<double> detect, round_trip;
  StageTimes stages;
  std::uint64_t hash[2] = {0, 0};
  Counters counters;

  void step(MovingScene& moving, int i, bool record) {
    moving.show(i);
    const DetectionResult& result = detector->detect(moving.scene, options);
    if (!record) {
      hash[i % 2] = hashOf(result.contacts);
      return;
    }
    if (i % 2 == 1) return;  // both states move; the first is the scene that is named
    detect.push_back(result.detect_ms);
    round_trip.push_back(result.round_trip_ms);
    counters = result.counters;
    stages.add(result);
  }
};

double least(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

void print(const MovingScene& moving, const Run& run, bool equal) {
  std::printf("| %s | %s | %d | %.3f | %.3f | %.3f | %llu | %016llx %016llx | %s |",
              moving.name.c_str(),
              run.options.adjacent == AdjacentPairs::kSkip ? "skip" : "beyond shared",
              run.options.threads, median(run.detect), least(run.detect), median(run.round_trip),
              static_cast<unsigned long long>(run.counters.candidates),
              static_cast<unsigned long long>(run.hash[0]),
              static_cast<unsigned long long>(run.hash[1]), equal ? "equal" : "DIFFERENT");
  for (const std::string& name : run.stages.names) {
    const std::vector<double>& ms = run.stages.ms.at(name);
    std::printf(" %s %.2f (%.2f)", name.c_str(), median(ms), least(ms));
  }
  std::printf(" |\n");
  std::fflush(stdout);
}

// Both modes in turn, so that what else the machine does is the same for them. False if the lists
// differ between numbers of threads.
bool measure(MovingScene& moving, const std::vector<int>& threads, int repeats) {
  constexpr int kWarmUp = 6, kTurn = 4;
  std::uint64_t expected[2][2] = {};
  bool all_equal = true;
  for (const int count : threads) {
    Run runs[2];
    runs[0].options.adjacent = AdjacentPairs::kSkip;
    for (Run& run : runs) {
      run.options.threads = count;
      for (int i = 0; i < kWarmUp; ++i) run.step(moving, i, false);
    }
    for (int turn = 0; turn < repeats; turn += kTurn) {
      for (Run& run : runs) {
        run.step(moving, 1, false);  // its memory is warm again
        for (int i = 0; i < 2 * kTurn; ++i) run.step(moving, i, true);
      }
    }
    for (int mode = 0; mode < 2; ++mode) {
      bool equal = true;
      for (int i = 0; i < 2; ++i) {
        if (count == threads[0]) expected[mode][i] = runs[mode].hash[i];
        equal = equal && runs[mode].hash[i] == expected[mode][i];
      }
      print(moving, runs[mode], equal);
      all_equal = all_equal && equal;
    }
  }
  return all_equal;
}

TriangleMesh readMesh(const char* file) { return readMeshFile(testDataFile(file)); }

MovingScene selfMoving(const std::string& name, const TriangleMesh& a, const TriangleMesh& b) {
  return {name, selfScene(a), {a.vertices, b.vertices}};
}

// Those whose names hold `only`; `threads`: the numbers of threads.
int run(const std::string& only, const std::vector<int>& threads, int repeats) {
  const TriangleMesh ball92 = readMesh("cloth-ball/cloth_ball92.ply");
  const TriangleMesh ball93 = readMesh("cloth-ball/cloth_ball93.ply");
  std::printf(
      "| scene | adjacent | threads | detect ms | least | round trip ms | candidates | contacts of "
      "both states | lists | stages: median (least) ms |\n|---|---|---|---|---|---|---|---|---|---|"
      "\n");
  const std::vector<std::function<MovingScene()>> scenes = {
      [&] { return selfMoving("cloth_ball92", ball92, ball93); },
      [&] { return selfMoving("cloth_ball93", ball93, ball92); },
      [] {
        return selfMoving("cloth-funnel 227", readMesh("cloth-funnel/227.ply"),
                          readMesh("cloth-funnel/228.ply"));
      },
      [&] {
        return selfMoving("cloth_ball92 split 3 x 3", splitThreeByThree(ball92),
                          splitThreeByThree(ball93));
      },
      [] { return movedUp("Panda and a cloth", pandaAndCloth()); }};
  bool all_equal = true;
  for (const auto& make : scenes) {
    MovingScene moving = make();
    if (moving.name.find(only) == std::string::npos) continue;
    divideIntoParts(moving);
    const bool large = moving.scene.triangleCount() > 500000;
    all_equal = measure(moving, threads, large ? std::max(repeats / 4, 1) : repeats) && all_equal;
  }
  return all_equal ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

// cpu_benchmark [SCENE [REPEATS [THREADS...]]]
int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  std::vector<int> threads;
  for (int i = 3; i < argc; ++i) threads.push_back(std::atoi(argv[i]));
  if (threads.empty()) threads = {1, 2};
  return dcm::runBenchmark("cpu_benchmark", [&] {
    return dcm::run(argc > 1 ? argv[1] : "", threads, argc > 2 ? std::atoi(argv[2]) : 24);
  });
}
