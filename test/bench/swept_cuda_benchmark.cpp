// Prints tables of contacts between two states on the CUDA backend: whole cycles and stages, moving
// input (the step forwards and backwards in turn), medians and 95th percentiles. Pair sets and
// first times are compared with the CPU backend's in the same run.
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu_detector.h"
#include "core/mesh_file.h"
#include "cuda/cuda_detector.h"
#include "robot_scenes.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "stage_times.h"
#include "test_data.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

int repeats = 100;  // after kWarmUp
constexpr int kWarmUp = 20;
bool all_equal = true;  // sets that were compared

// A scene with a step, taken forwards and backwards in turn.
struct Stepping {
  std::string name;
  Scene forwards;         // what the step is
  double at_most_ms;      // the figure to reach
  Scene scene{forwards};  // as it is looked at

  // Forwards if `i` is even. Vertices are sent again.
  void set(int i) {
    for (BodyId b = 0; b < scene.bodyCount(); ++b) {
      const Body& body = forwards.body(b);
      const EarlierState& earlier = *body.earlier;
      const bool back = i % 2 == 1;
      if (!earlier.vertices.empty()) {
        const std::vector<float>& now = back ? earlier.vertices : body.mesh.vertices;
        scene.setVertices(b, now.data(), now.size() / 3);
      }
      std::vector<float> before;
      if (!earlier.vertices.empty()) before = back ? body.mesh.vertices : earlier.vertices;
      scene.setPose(b, back ? earlier.pose : body.pose);
      scene.setEarlier(b, back ? body.pose : earlier.pose, std::move(before));
    }
  }
};

const DetectionResult& step(Stepping& scene, int i, Detector& detector, const Options& options) {
  scene.set(i);
  return detector.detect(scene.scene, options);
}

bool areEqual(Stepping& scene, Detector& detector, const Options& options) {
  const auto reference = makeCpuDetector();
  bool equal = true;
  for (int i = 0; i < 2; ++i) {
    const DetectionResult& expected = step(scene, i, *reference, options);
    const DetectionResult& found = step(scene, i, detector, options);
    equal = equal && found.contacts == expected.contacts;
    for (std::size_t k = 0; equal && k < found.first_times.size(); ++k) {
      const FirstContact &first = found.first_times[k], &other = expected.first_times[k];
      equal = 0 <= first.low && first.high <= 1 && first.high - first.low <= 0x1p-20F &&
              first.low <= other.high && other.low <= first.high;
    }
  }
  return equal;
}

double stageOf(const DetectionResult& result, const std::string& name) {
  for (const auto& [stage, ms] : result.stages_ms) {
    if (stage == name) return ms;
  }
  return 0;
}

void whole(Stepping& scene, const Options& options) {
  const auto detector = makeCudaDetector();
  for (int i = 0; i < kWarmUp; ++i) step(scene, i, *detector, options);
  std::vector<double> device, detect, round_trip;
  DetectionResult last;
  for (int i = 0; i < 2 * repeats; ++i) {
    const DetectionResult& result = step(scene, i, *detector, options);
    if (i % 2 == 1) continue;  // the step that is named goes forwards
    device.push_back(stageOf(result, "transform_to_narrow_phase"));
    detect.push_back(result.detect_ms);
    round_trip.push_back(result.round_trip_ms);
    if (i + 2 >= 2 * repeats) last = result;
  }
  const bool equal = areEqual(scene, *detector, options);
  all_equal = all_equal && equal;
  const Counters& c = last.counters;
  std::printf(
      "| %s | %s%s | %llu | %zu | %.3f | %.3f | %.3f | %.3f | %.3f | %.3f | %llu | %llu | %.2f | "
      "%llu | %llu | %.0f | %s |\n",
      scene.name.c_str(), toString(options.adjacent), options.first_times ? ", first times" : "",
      static_cast<unsigned long long>(c.triangles), last.contacts.size(), scene.at_most_ms,
      median(device), percentile(device, 0.95), median(detect), median(round_trip),
      percentile(round_trip, 1), static_cast<unsigned long long>(c.interval_overlaps),
      static_cast<unsigned long long>(c.candidates),
      static_cast<double>(c.cluster_entries) / static_cast<double>(c.clustered + 1e-9),
      static_cast<unsigned long long>(c.clusters), static_cast<unsigned long long>(c.exact),
      static_cast<double>(last.detector_bytes) / static_cast<double>(c.triangles),
      equal ? "equal" : "DIFFERENT");
  std::fflush(stdout);
}

void stages(Stepping& scene, const Options& options) {
  CudaSettings settings;
  settings.time_stages = true;
  const auto detector = makeCudaDetector(settings);
  StageTimes times;
  for (int i = 0; i < kWarmUp + 2 * repeats; ++i) {
    const DetectionResult& result = step(scene, i, *detector, options);
    if (i >= kWarmUp && i % 2 == 0) times.add(result);
  }
  times.print(scene.name);
}

Stepping selfStepping(const std::string& name, const char* from, const char* to,
                      double at_most_ms) {
  const TriangleMesh a = readMeshFile(testDataFile(from)), b = readMeshFile(testDataFile(to));
  Scene scene = selfScene(b);
  scene.setEarlier(0, RigidTransform(), a.vertices);
  return {name, scene, at_most_ms};
}

int run(const std::string& only) {
  const std::vector<std::function<Stepping()>> scenes = {
      [] {
        return selfStepping("cloth_ball 92 -> 93", "cloth-ball/cloth_ball92.ply",
                            "cloth-ball/cloth_ball93.ply", 1.0);
      },
      [] {
        return selfStepping("cloth-funnel 227 -> 228", "cloth-funnel/227.ply",
                            "cloth-funnel/228.ply", 0.2);
      },
      [] {
        return Stepping{"Panda and a cloth, both moving", movingPandaAndCloth(), 0.1};
      }};
  Options options;
  options.motion = Motion::kSwept;
  if (const char* clusters = std::getenv("DCM_BENCH_CLUSTERS")) {
    options.clusters = std::atoi(clusters);
  }
  if (const char* count = std::getenv("DCM_BENCH_REPEATS")) repeats = std::atoi(count);
  std::printf(
      "| scene | adjacent | triangles | contacts | at most ms | device ms | p95 | with the host's "
      "part ms | round trip ms | worst | overlaps | candidates | clusters a triangle | clusters | "
      "exact | "
      "bytes a triangle | sets |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& make : scenes) {
    Stepping scene = make();
    if (!only.empty() && scene.name.find(only) == std::string::npos) continue;
    options.adjacent = AdjacentPairs::kSkip;
    if (std::getenv("DCM_BENCH_STAGES")) {
      for (const bool times : {false, true}) {
        options.first_times = times;
        stages(scene, options);
      }
      options.first_times = false;
      continue;
    }
    whole(scene, options);
    options.first_times = true;
    whole(scene, options);
    options.first_times = false;
    options.adjacent = AdjacentPairs::kBeyondShared;
    whole(scene, options);
    options.first_times = true;
    whole(scene, options);
    options.first_times = false;
    options.adjacent = AdjacentPairs::kSkip;
    stages(scene, options);
  }
  return all_equal ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runBenchmark("swept_cuda_benchmark",
                           [argc, argv] { return dcm::run(argc > 1 ? argv[1] : ""); });
}
