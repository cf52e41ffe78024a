// Prints what a tolerance saves, and how well a deadline is kept, on one CPU thread: medians,
// moving input; states of all pairs of bodies are compared with the exact ones.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/body_distance.h"
#include "core/common/stopwatch.h"
#include "core/cpu_detector.h"
#include "core/mesh_file.h"
#include "cuda/detector_choice.h"
#include "moving_scene.h"
#include "robot_scenes.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "test_data.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

// Triangles of `size` anywhere in a box of 1 m.
TriangleMesh randomTriangles(std::uint32_t seed, int count, float size) {
  std::mt19937 random(seed);
  const auto unit = [&random] { return static_cast<float>(random()) * 0x1p-32F; };
  std::vector<Triangle> triangles(static_cast<std::size_t>(count));
  for (Triangle& t : triangles) {
    const Vec3f at{unit(), unit(), unit()};
    for (Vec3f& v : t.v) v = at + Vec3f{unit(), unit(), unit()} * size;
  }
  return meshOf(triangles);
}

struct Run {
  Options options;
  double budget_ms = 0;  // 0: none
  std::shared_ptr<TilingCache> tilings = std::make_shared<TilingCache>();
  std::unique_ptr<Detector> detector =
      makeDetector(BackendChoice::kCpu, WithoutCuda::kRefuse, CudaSettings(), nullptr, tilings);
  std::vector<double> times_ms;
  std::size_t decided = 0, pairs = 0, contacts = 0, missed = 0, listed = 0;
  std::vector<std::pair<std::string, double>> stages_ms;

  void forget() {
    times_ms.clear();
    decided = pairs = contacts = missed = listed = 0;
  }

  void step(MovingScene& moving, int i, const std::set<std::pair<BodyId, BodyId>>& touching) {
    moving.show(i);
    const Stopwatch watch;
    if (budget_ms > 0) {
      options.limits.deadline = std::chrono::steady_clock::now() + fromSeconds(budget_ms / 1000);
    }
    const DetectionResult& result = detector->detect(moving.scene, options);
    times_ms.push_back(watch.elapsedMs());
    stages_ms = result.stages_ms;
    if (result.distances.empty()) return;  // exact
    for (const BodyDistance& distance : result.distances) {
      const PairDecision decision = decide(distance, 0, options.tolerance_m);
      ++pairs;
      decided += decision != PairDecision::kOpen;
      contacts += decision == PairDecision::kContact;
      listed += distance.is_listed;
      missed +=
          decision == PairDecision::kNone && touching.count({distance.body_a, distance.body_b}) > 0;
    }
  }
};

std::set<std::pair<BodyId, BodyId>> touchingPairs(MovingScene& moving, int i) {
  moving.show(i);
  const auto exact = makeCpuDetector();
  Options options;
  options.limits.deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::set<std::pair<BodyId, BodyId>> touching;
  for (const TrianglePair& pair : exact->detect(moving.scene, options).contacts) {
    touching.emplace(pair.body_a, pair.body_b);
  }
  return touching;
}

void print(const MovingScene& moving, const Run& run) {
  std::vector<double> sorted = run.times_ms;
  std::sort(sorted.begin(), sorted.end());
  const double percent = run.pairs == 0 ? 0 : 100.0 / static_cast<double>(run.pairs);
  std::printf("| %s | %zu | %g | %g | %.3f | %.3f | %.3f | %.3f | %.0f | %.0f | %.0f | %zu |",
              moving.name.c_str(), moving.scene.triangleCount(), 1000 * run.options.tolerance_m,
              run.budget_ms, sorted[sorted.size() / 2], sorted.front(),
              sorted[sorted.size() * 99 / 100], sorted.back(),
              static_cast<double>(run.decided) * percent,
              static_cast<double>(run.contacts) * percent,
              static_cast<double>(run.listed) * percent, run.missed);
  for (const auto& [name, ms] : run.stages_ms) std::printf(" %s %.2f", name.c_str(), ms);
  std::printf(" |\n");
  std::fflush(stdout);
}

bool measure(MovingScene& moving, int repeats) {
  constexpr int kWarmUp = TilingCache::kSettledAfter + 1, kMore = 4;  // until ends are met
  constexpr double kMostMs = 3000;                                    // of a row without a budget
  std::vector<Run> runs;
  for (const double budget_ms : {2.0, 5.0, 10.0, 33.0}) {
    runs.emplace_back();
    runs.back().budget_ms = budget_ms;
  }
  for (const float tolerance_mm : {0.0F, 1.0F, 2.0F, 5.0F, 10.0F}) {
    runs.emplace_back();
    runs.back().options.tolerance_m = tolerance_mm / 1000;
  }
  std::size_t missed = 0;
  const std::set<std::pair<BodyId, BodyId>> touching[2] = {touchingPairs(moving, 0),
                                                           touchingPairs(moving, 1)};
  for (Run& run : runs) {
    run.options.threads = 1;
    const int steps = run.budget_ms > 0 ? 8 * repeats : repeats;
    for (int i = 0; i < kWarmUp; ++i) run.step(moving, i, touching[i % 2]);
    run.tilings->wait();
    for (int i = 0; i < kMore && run.budget_ms > 0; ++i) run.step(moving, i, touching[i % 2]);
    run.forget();
    const Stopwatch watch;
    for (int i = 0; i < steps && (run.budget_ms > 0 || watch.elapsedMs() < kMostMs); ++i) {
      run.step(moving, i, touching[i % 2]);
      // A deadline is for cycles with pauses between; and a thread that always runs is stopped some
      // time by the system.
      if (run.budget_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    print(moving, run);
    missed += run.missed;
  }
  return missed == 0;
}

int run(const std::string& only, int repeats) {
  std::printf(
      "| scene | triangles | tolerance mm | budget ms | median ms | least | p99 | most | decided "
      "%% "
      "| contact %% | listed %% | missed | stages ms "
      "|\n|---|---|---|---|---|---|---|---|---|---|---"
      "|---|---|\n");
  bool all_found = true;
  const std::vector<std::function<MovingScene()>> scenes = {
      [] { return movedUp("Panda and a cloth, 15k", pandaAndCloth()); },
      [] { return movedUp("Panda and a cloth, 92k", pandaAndCloth(215)); },
      [] { return movedUp("Panda and a cloth, 1M", pandaAndCloth(707)); },
      [] {
        return movedUp(
            "cloths 6 mm apart, 2 x 92k",
            pairScene(clothGrid(215, 1.2F, 0, 0.12F), clothGrid(211, 1.2F, 0.006F, 0.12F)));
      },
      [] {
        return movedUp("a crumpled cloth with itself, 92k",
                       selfScene(readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply"))));
      },
      [] {
        return movedUp("soups that cross",
                       pairScene(randomTriangles(1, 10000, 0.1F), randomTriangles(2, 10000, 0.1F)));
      },
      [] {
        return movedUp("soups of 1 m",
                       pairScene(randomTriangles(1, 10000, 1), randomTriangles(2, 10000, 1)));
      },
      [] {
        Scene scene = pairScene(randomTriangles(1, 10000, 1), randomTriangles(2, 10000, 1));
        scene.setPairEnabled(0, 0, true);
        return movedUp("the same, one of them with itself", std::move(scene));
      }};
  for (const auto& make : scenes) {
    MovingScene scene = make();
    if (scene.name.find(only) == std::string::npos) continue;
    all_found = measure(scene, repeats) && all_found;
  }
  return all_found ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

// tolerance_benchmark [SCENE [REPEATS]]
int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runBenchmark("tolerance_benchmark", [&] {
    return dcm::run(argc > 1 ? argv[1] : "", argc > 2 ? std::atoi(argv[2]) : 40);
  });
}
