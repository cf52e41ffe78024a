// Prints tables of the CUDA backend on real scenes: whole cycles and stages, moving input, medians
// and 95th percentiles; pair sets are compared with the CPU backend's in the same run.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "core/mesh_file.h"
#include "cuda/cuda_detector.h"
#include "layered_cloth.h"
#include "moving_scene.h"
#include "robot_scenes.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "stage_times.h"
#include "test_data.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kWarmUp = 40, kRepeats = 100;
constexpr std::size_t kManyTriangles = 500000;  // from here on a tenth of the repeats

bool all_equal = true;  // sets that were compared
bool only_growth = false;

struct Moving : MovingScene {
  double at_most_ms = 0;  // the figure to reach; 0: none
};

int repeatsFor(const Moving& moving) {
  return only_growth && moving.scene.triangleCount() > kManyTriangles ? kRepeats / 10 : kRepeats;
}

const DetectionResult& step(Moving& moving, int i, Detector& detector, const Options& options) {
  moving.show(i);
  return detector.detect(moving.scene, options);
}

bool setsEqual(Moving& moving, Detector& detector, Detector& reference, const Options& options) {
  bool equal = true;
  for (int i = 0; i < 2; ++i) {
    const std::vector<TrianglePair> expected = step(moving, i, reference, options).contacts;
    equal = equal && step(moving, i, detector, options).contacts == expected;
  }
  return equal;
}

const char* what(const Options& options) {
  if (options.geometry) return "skip, with geometry";
  return options.adjacent == AdjacentPairs::kSkip ? "skip" : "beyond shared";
}

void whole(Moving& moving, const Options& options, bool check) {
  const auto detector = makeCudaDetector();
  moving.scene.useMemory(detector->vertexMemory());
  for (int i = 0; i < (only_growth ? 10 : kWarmUp); ++i) step(moving, i, *detector, options);
  std::vector<double> detect, round_trip, there, back;
  DetectionResult last;
  const int repeats = repeatsFor(moving);
  for (int i = 0; i < 2 * repeats; ++i) {
    const DetectionResult& result = step(moving, i, *detector, options);
    if (i % 2 == 1) continue;  // both states move; the first is the scene that is named
    detect.push_back(result.detect_ms);
    round_trip.push_back(result.round_trip_ms);
    there.push_back(1e3 * result.stages_ms.front().second);
    back.push_back(1e3 * result.stages_ms.back().second);
    if (i + 2 >= 2 * repeats) last = result;
  }
  const char* sets = "-";
  if (check) {
    Options on_cpu = options;
    on_cpu.clusters = 0;
    const bool equal = setsEqual(moving, *detector, *makeCpuDetector(), on_cpu);
    sets = equal ? "equal" : "DIFFERENT";
    all_equal = all_equal && equal;
  }
  const Counters& c = last.counters;
  std::printf(
      "| %s | %s | %llu | %zu | %.3f | %.4f | %.4f | %.3f | %.3f | %.0f | %.0f | %llu | %llu | "
      "%.2f | %llu | "
      "%llu | %.0f | %s |\n",
      moving.name.c_str(), what(options), static_cast<unsigned long long>(c.triangles),
      last.contacts.size(), moving.at_most_ms, median(detect), percentile(detect, 0.95),
      median(round_trip), percentile(round_trip, 0.95), median(there), median(back),
      static_cast<unsigned long long>(c.interval_overlaps),
      static_cast<unsigned long long>(c.candidates),
      c.clustered > 0 ? static_cast<double>(c.cluster_entries) / static_cast<double>(c.clustered)
                      : 0,
      static_cast<unsigned long long>(c.clusters), static_cast<unsigned long long>(c.exact),
      static_cast<double>(last.detector_bytes) / static_cast<double>(c.triangles), sets);
  std::fflush(stdout);
}

void stages(Moving& moving, const Options& options) {
  CudaSettings settings;
  settings.time_stages = true;
  const auto detector = makeCudaDetector(settings);
  moving.scene.useMemory(detector->vertexMemory());
  StageTimes times;
  for (int i = 0; i < kWarmUp + 2 * repeatsFor(moving); ++i) {
    const DetectionResult& result = step(moving, i, *detector, options);
    if (i >= kWarmUp && i % 2 == 0) times.add(result);
  }
  times.print(moving.name);
}

Moving selfMoving(const std::string& name, const TriangleMesh& a, const TriangleMesh& b,
                  double at_most_ms) {
  return {{name, selfScene(a), {a.vertices, b.vertices}}, at_most_ms};
}

// The cloth with what must cost next to nothing.
Moving withHugeTriangles(Moving moving) {
  moving.name += ", two huge triangles";
  for (std::vector<float>& state : moving.state) {
    for (const float z : {0.0F, 0.1F}) {
      state.insert(state.end(), {-1000, -1000, z, 1000, -1000, z, 0, 1000, z + 0.01F});
    }
  }
  TriangleMesh mesh = moving.scene.body(0).mesh;
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  mesh.vertices = moving.state[0];
  for (std::uint32_t i = 0; i < 6; ++i) mesh.triangles.push_back(first + i);
  moving.scene.setMesh(0, mesh);
  return moving;
}

Moving withOutlier(Moving moving) {
  moving.name += ", a vertex at 1e30";
  for (std::vector<float>& state : moving.state) state[0] = 1e30F;
  return moving;
}

Moving withFarBodies(Moving moving) {
  moving.name += ", 20 far bodies";
  for (int i = 0; i < 20; ++i) {
    const BodyId far = moving.scene.addBody("far", clothGrid(20, 1, 0, 0.1F));
    RigidTransform pose;
    pose.translation[0] = 50 + 5 * i;
    moving.scene.setPose(far, pose);
    moving.scene.setPairEnabled(0, far, true);
  }
  return moving;
}

// The cloth above a terrain of 100 m, whose 80 000 triangles are much larger.
Moving withTerrain(Moving moving) {
  moving.name += ", a terrain of 100 m";
  const BodyId terrain = moving.scene.addBody("terrain", clothGrid(200, 100, 0.5, 1));
  RigidTransform pose;
  for (int k = 0; k < 2; ++k) pose.translation[k] = -50;
  moving.scene.setPose(terrain, pose);
  moving.scene.setPairEnabled(0, terrain, true);
  return moving;
}

// A million triangles of some 3 mm with vertices of their own, in a cube of 1 m.
TriangleMesh sparseSoup() {
  constexpr std::uint32_t kVertices = 3000000;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> within(0, 1), near(0, 0.003F);
  TriangleMesh mesh;
  float corner[3] = {};
  for (std::uint32_t v = 0; v < kVertices; ++v) {
    for (float& x : corner) {
      if (v % 3 == 0) x = within(random);
      mesh.vertices.push_back(x + near(random));
    }
    mesh.triangles.push_back(v);
  }
  return mesh;
}

using MakeMoving = std::function<Moving()>;

TriangleMesh readMesh(const char* file) { return readMeshFile(testDataFile(file)); }

std::vector<MakeMoving> namedScenes(const TriangleMesh& ball92, const TriangleMesh& ball93) {
  return {[&] { return selfMoving("cloth_ball92", ball92, ball93, 0.20); },
          [&] { return selfMoving("cloth_ball93", ball93, ball92, 0.28); },
          [] {
            return selfMoving("cloth-funnel 227", readMesh("cloth-funnel/227.ply"),
                              readMesh("cloth-funnel/228.ply"), 0.10);
          },
          [&] {
            return selfMoving("cloth_ball92 split 3 x 3", splitThreeByThree(ball92),
                              splitThreeByThree(ball93), 0.75);
          },
          [] {
            return Moving{movedUp("Panda and a cloth", pandaAndCloth()), 0.08};
          },
          [] {
            return Moving{allMovedUp("a moving Panda and a cloth", pandaAndCloth()), 0.08};
          },
          [] {
            return Moving{layeredCloths(), 0};
          },
          [] {
            return Moving{movedUp("sparse soup", selfScene(sparseSoup())), 0.5};
          },
          [&] { return selfMoving("soup of cloth_ball92", soupOf(ball92), soupOf(ball93), 0); },
          [&] {
            return selfMoving("soup of cloth_ball92 split 3 x 3", soupOf(splitThreeByThree(ball92)),
                              soupOf(splitThreeByThree(ball93)), 0);
          }};
}

void printGrowth(const TriangleMesh& ball92, const TriangleMesh& ball93, const Options& options) {
  for (const std::size_t n : {1000U, 10000U, 92230U, 300000U, 1000000U, 3000000U, 10000000U}) {
    Moving moving = selfMoving("copies of cloth_ball92", sizedTo(ball92, n), sizedTo(ball93, n), 0);
    whole(moving, options, n < kManyTriangles);
    stages(moving, options);
  }
}

// Those whose names hold `only`.
void printScenes(const std::vector<MakeMoving>& scenes, const std::string& only, Options options) {
  for (const auto& make : scenes) {
    Moving moving = make();
    if (!only.empty() && moving.name.find(only) == std::string::npos) continue;
    divideIntoParts(moving);
    if (std::getenv("DCM_BENCH_STAGES")) {
      for (const AdjacentPairs adjacent : {AdjacentPairs::kSkip, AdjacentPairs::kBeyondShared}) {
        options.adjacent = adjacent;
        stages(moving, options);
      }
      break;
    }
    whole(moving, options, true);
    options.adjacent = AdjacentPairs::kBeyondShared;
    whole(moving, options, true);
    options.adjacent = AdjacentPairs::kSkip;
    options.geometry = true;
    whole(moving, options, true);
    options.geometry = false;
    stages(moving, options);
  }
}

int run(const std::string& only) {
  const TriangleMesh ball92 = readMesh("cloth-ball/cloth_ball92.ply");
  const TriangleMesh ball93 = readMesh("cloth-ball/cloth_ball93.ply");
  Options options;
  options.adjacent = AdjacentPairs::kSkip;
  if (const char* clusters = std::getenv("DCM_BENCH_CLUSTERS")) {
    options.clusters = std::atoi(clusters);
  }
  std::printf(
      "| scene | adjacent | triangles | contacts | at most ms | detect ms | p95 | round trip ms | "
      "p95 | upload us | output us | overlaps | candidates | clusters a triangle | clusters | "
      "exact | bytes a triangle | "
      "sets |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  if (only == "growth") {
    only_growth = true;
    printGrowth(ball92, ball93, options);
    return all_equal ? 0 : 1;
  }
  printScenes(namedScenes(ball92, ball93), only, options);
  const Moving cloth = selfMoving("cloth_ball92", ball92, ball93, 0);
  for (const auto& change : {withHugeTriangles, withOutlier, withFarBodies, withTerrain}) {
    Moving moving = change(cloth);
    if (moving.name.find(only) == std::string::npos) continue;
    whole(moving, options, true);
    stages(moving, options);
  }
  return all_equal ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runBenchmark("cuda_benchmark",
                           [argc, argv] { return dcm::run(argc > 1 ? argv[1] : ""); });
}
