// Prints a table: this detector and others on real scenes, one thread each, medians.
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/common/stopwatch.h"
#include "core/cpu_detector.h"
#include "core/mesh_file.h"
#include "reference/reference_detectors.h"
#include "rivals.h"
#include "robot_scenes.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "test_data.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

struct Measured {
  double median_ms, least_ms;
  std::size_t pairs;
};

// `job` returns its time [ms], or a negative number to be timed from outside, and sets the pairs.
Measured measure(int repeats, const std::function<double(std::size_t*)>& job) {
  std::vector<double> ms;
  std::size_t pairs = 0;
  job(&pairs);  // warm-up
  for (int i = 0; i < repeats; ++i) {
    const Stopwatch stopwatch;
    const double own_ms = job(&pairs);
    ms.push_back(own_ms < 0 ? stopwatch.elapsedMs() : own_ms);
  }
  return {median(ms), *std::min_element(ms.begin(), ms.end()), pairs};
}

void row(const char* scene, const char* what, const Measured& m) {
  std::printf("| %s | %s | %.2f | %.2f | %zu |\n", scene, what, m.median_ms, m.least_ms, m.pairs);
  std::fflush(stdout);
}

// Sends body 0's vertices again before each cycle, those of its earlier state too, so that nothing
// of them can be cached.
Measured measureDetector(int repeats, Detector* detector, Scene* scene, const Options& options,
                         bool round_trip) {
  const std::vector<float> vertices = scene->body(0).mesh.vertices;
  return measure(repeats, [&](std::size_t* pairs) {
    scene->setVertices(0, vertices.data(), vertices.size() / 3);
    const std::optional<EarlierState> earlier = scene->body(0).earlier;
    if (earlier) scene->setEarlier(0, earlier->pose, earlier->vertices);
    const DetectionResult& result = detector->detect(*scene, options);
    *pairs = result.contacts.size();
    return round_trip ? result.round_trip_ms : result.detect_ms;
  });
}

// Measures how much geometry adds to the round trip.
void geometryRows() {
  Scene scene = selfScene(readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply")));
  for (const int threads : {1, 2}) {
    for (const bool geometry : {false, true}) {
      Options options;
      options.adjacent = AdjacentPairs::kSkip;
      options.threads = threads;
      options.geometry = geometry;
      const auto detector = makeCpuDetector();
      const std::string what = std::string("ours, ") +
                               (threads == 1 ? "one thread" : "two threads") +
                               (geometry ? ", with geometry" : "") + ": round trip";
      row("cloth_ball92, self", what.c_str(),
          measureDetector(25, detector.get(), &scene, options, true));
    }
  }
}

// A step of a mesh in two states, self, neighbours skipped and not, with and without first times.
void sweptMeshRows(const char* name, const std::string& from, const std::string& to) {
  Scene scene = selfScene(readMeshFile(testDataFile(to)));
  scene.setEarlier(0, RigidTransform(), readMeshFile(testDataFile(from)).vertices);
  for (const AdjacentPairs adjacent : {AdjacentPairs::kSkip, AdjacentPairs::kBeyondShared}) {
    for (const bool times : {false, true}) {
      Options options;
      options.motion = Motion::kSwept;
      options.threads = 1;
      options.adjacent = adjacent;
      options.first_times = times;
      const auto detector = makeCpuDetector();
      const std::string what =
          std::string("swept, ") + toString(adjacent) + (times ? ", first times" : "") + ": detect";
      row(name, what.c_str(), measureDetector(9, detector.get(), &scene, options, false));
    }
  }
}

void sweptRows() {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  sweptMeshRows("cloth_ball 92 to 93, self", "cloth-ball/cloth_ball92.ply",
                "cloth-ball/cloth_ball93.ply");
  sweptMeshRows("cloth-funnel 227 to 228, self", "cloth-funnel/227.ply", "cloth-funnel/228.ply");
  Scene robot = movingPandaAndCloth();
  for (const bool times : {false, true}) {
    Options options;
    options.motion = Motion::kSwept;
    options.threads = 1;
    options.first_times = times;
    const auto detector = makeCpuDetector();
    row("Panda and a cloth of 15 138 triangles, both moving",
        times ? "swept, first times: detect" : "swept: detect",
        measureDetector(100, detector.get(), &robot, options, false));
  }
}

void oneThreadRows() {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  Options options;
  options.threads = 1;
  options.adjacent = AdjacentPairs::kSkip;
  const TriangleMesh cloth = readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply"));
  const char* name = "cloth_ball92, self";
  Scene scene = selfScene(cloth);
  const auto detector = makeCpuDetector();
  row(name, "ours, exact, neighbours skipped: detect",
      measureDetector(25, detector.get(), &scene, options, false));
  row(name, "ours, exact, neighbours skipped: round trip",
      measureDetector(25, detector.get(), &scene, options, true));
  options.adjacent = AdjacentPairs::kBeyondShared;
  row(name, "ours, exact, beyond shared: detect",
      measureDetector(25, detector.get(), &scene, options, false));
  row(name, "CGAL box_self_intersection_d (boxes only)",
      measure(9, [&](std::size_t* pairs) { return *pairs = cgalBoxPairs(cloth), -1.0; }));
#ifdef DCM_HAVE_EMBREE
  row(name, "Embree rtcCollide (boxes of leaves only)",
      measure(15, [&](std::size_t* pairs) { return *pairs = embreeBoxPairs(cloth), -1.0; }));
#endif
#ifdef DCM_HAVE_FCL
  options.adjacent = AdjacentPairs::kSkip;
  const auto fcl = makeFclDetector();
  row(name, "FCL BVHModel (triangles in floating point)",
      measureDetector(5, fcl.get(), &scene, options, false));
#endif

  options.adjacent = AdjacentPairs::kBeyondShared;
  Scene robot = pandaAndCloth();
  const auto robot_detector = makeCpuDetector();
  name = "Panda against a cloth of 15 138 triangles";
  row(name, "ours, exact: detect",
      measureDetector(200, robot_detector.get(), &robot, options, false));
  row(name, "ours, exact: round trip",
      measureDetector(200, robot_detector.get(), &robot, options, true));
}

// The argument "geometry" or "swept" selects these rows alone.
int run(const std::string& only) {
  std::printf("| scene | what | median ms | least ms | pairs |\n|---|---|---|---|---|\n");
  if (only.empty()) oneThreadRows();
  if (only.empty() || only == "geometry") geometryRows();
  if (only.empty() || only == "swept") sweptRows();
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runBenchmark("benchmark", [argc, argv] { return dcm::run(argc > 1 ? argv[1] : ""); });
}
