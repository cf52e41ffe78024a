// Prints what the distance and the nearest pair of bodies cost: a robot's hand over cloths of three
// sizes and a whole robot beside a crumpled cloth, input that moves, on one CPU thread or on CUDA,
// beside the cycle without a margin and FCL's distance. Nearest pairs are compared with brute
// force.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/common/stopwatch.h"
#include "core/mesh_file.h"
#include "cuda/detector_choice.h"
#include "moving_scene.h"
#include "reference/reference_detectors.h"
#include "robot_scenes.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "test_data.h"
#include "tools/common/sample_statistics.h"
#ifdef DCM_HAVE_FCL
#include "fcl_distance.h"
#endif

namespace deformable_contact_monitor {
namespace {

constexpr double kMostPairsByBruteForce = 4e8;

bool all_equal = true;  // nearest pairs that were compared

enum class Margin { kNone, kNearest, kNearestNewTopology, kNearPairs };

struct Settings {
  BackendChoice backend = BackendChoice::kCpu;
  int repeats = 60;
  std::string only;  // a part of the names of the scenes; empty: all
};

TriangleMesh hand() {
  return readMeshFile(testDataFile("robots/panda_description/meshes/collision/hand.stl"));
}

// A cloth of 2 n n triangles and 1.2 m, and the hand pointing down 6 cm above its highest point.
MovingScene handOverCloth(int n, float wave_m) {
  constexpr float kSide = 1.2F, kGap = 0.06F;
  Scene scene = pairScene(clothGrid(n, kSide, 0, wave_m), hand());
  float reach = 0;
  const auto& xyz = scene.body(1).mesh.vertices;
  for (std::size_t i = 2; i < xyz.size(); i += 3) reach = std::max(reach, xyz[i]);
  RigidTransform pose;  // turned about x by 180 degrees
  pose.rotation[4] = pose.rotation[8] = -1;
  pose.translation[0] = pose.translation[1] = kSide / 2.1;
  pose.translation[2] = double{reach} + wave_m + kGap;
  scene.setPose(1, pose);
  const std::string name = "hand over a " + std::string(wave_m > 0 ? "wavy" : "flat") + " cloth";
  return movedUp(name, std::move(scene));
}

// The file is 26 m wide with y up. Returns it as 1 m with z up.
TriangleMesh clothOnBall(const char* file) {
  constexpr float kScale = 0.04F;
  TriangleMesh mesh = readMeshFile(testDataFile(file));
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    float* const v = &mesh.vertices[i];
    const float y = v[1];
    v[0] *= kScale;
    v[1] = -kScale * v[2];
    v[2] = kScale * y;
  }
  return mesh;
}

// The Panda and a cloth crumpled on a ball, whose middle is so far in front of the robot. The
// cloth's second state is the next frame.
MovingScene pandaAndBall(const std::string& name, double ahead_m) {
  const TriangleMesh a = clothOnBall("cloth-ball/cloth_ball92.ply");
  const TriangleMesh b = clothOnBall("cloth-ball/cloth_ball93.ply");
  Scene scene = pandaAndCloth(1);
  scene.setMesh(0, a);
  RigidTransform pose;
  pose.translation[0] = ahead_m;
  pose.translation[2] = 0.3;
  scene.setPose(0, pose);
  return {name, std::move(scene), {a.vertices, b.vertices}};
}

double pairsOf(const Scene& scene) {
  double pairs = 0;
  for (const auto& [a, b] : scene.enabledPairs()) {
    pairs += static_cast<double>(scene.body(a).mesh.triangleCount()) *
             static_cast<double>(scene.body(b).mesh.triangleCount());
  }
  return pairs;
}

double leastOf(const std::vector<NearestPair>& nearest) {
  double least_m = INFINITY;
  for (const NearestPair& pair : nearest) least_m = std::min<double>(least_m, pair.distance_m);
  return least_m;
}

using BothStates = std::vector<std::vector<NearestPair>>;

// The nearest pairs of both states by brute force, within any margin; empty where that takes too
// long.
BothStates expectedOf(MovingScene moving) {
  BothStates expected;
  if (pairsOf(moving.scene) > kMostPairsByBruteForce) return expected;
  Options options;
  options.nearest = true;
  moving.scene.setMargin(0, 100);
  const auto exact = makeBruteForceDetector();
  for (int i = 0; i < 2; ++i) {
    moving.show(i);
    expected.push_back(exact->detect(moving.scene, options).nearest);
  }
  return expected;
}

std::vector<NearestPair> within(float margin_m, const std::vector<NearestPair>& all) {
  std::vector<NearestPair> some;
  for (const NearestPair& pair : all) {
    if (pair.distance_m <= margin_m) some.push_back(pair);
  }
  return some;
}

// The processor time of this thread [ms], which other processes do not add to.
double processorMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

struct Times {
  double first_ms = 0;
  std::vector<double> whole, processor, round_trip, detect;

  void print() const {
    std::printf(" %.3f | %.3f | %.3f | %.3f | %.3f | %.3f | %.3f |", first_ms, median(processor),
                median(whole), percentile(whole, 1e-9), percentile(whole, 0.95), median(round_trip),
                median(detect));
  }
};

const char* toString(Margin margin) {
  switch (margin) {
    case Margin::kNone:
      return "no margin";
    case Margin::kNearest:
      return "nearest";
    case Margin::kNearestNewTopology:
      return "nearest, new topology each cycle";
    default:
      return "near pairs, no nearest";
  }
}

// Runs cycles of one detector, prints a row, and compares the nearest pairs.
void measure(const Settings& settings, MovingScene moving, float margin_m, Margin margin,
             const BothStates& expected) {
  constexpr double kWarmUpMs = 1000, kMostMs = 3000;
  constexpr int kWarmUp = 12;
  Options options;
  options.threads = 1;
  options.nearest = margin == Margin::kNearest || margin == Margin::kNearestNewTopology;
  for (BodyId id = 0; id < moving.scene.bodyCount(); ++id) {
    moving.scene.setMargin(id, margin == Margin::kNone ? 0 : margin_m);
  }
  const auto detector = makeDetector(settings.backend, WithoutCuda::kRefuse);
  moving.scene.useMemory(detector->vertexMemory());
  const TriangleMesh mesh = moving.scene.body(0).mesh;
  Times times;
  bool equal = true;
  double distance_m = INFINITY;
  std::size_t contacts = 0;
  const auto step = [&](int i) {
    if (margin == Margin::kNearestNewTopology) moving.scene.setMesh(0, mesh);
    moving.show(i);
    const Stopwatch watch;
    const double before_ms = processorMs();
    const DetectionResult& result = detector->detect(moving.scene, options);
    times.processor.push_back(processorMs() - before_ms);
    const double ms = watch.elapsedMs();
    distance_m = leastOf(result.nearest);
    contacts = result.contacts.size();
    if (options.nearest && !expected.empty()) {
      equal = equal && result.nearest == within(margin_m, expected[i % 2]);
    }
    times.round_trip.push_back(result.round_trip_ms);
    times.detect.push_back(result.detect_ms);
    times.whole.push_back(ms);
    return ms;
  };
  times.first_ms = step(0);
  const Stopwatch watch;
  for (int i = 1; i < kWarmUp || (watch.elapsedMs() < kWarmUpMs && i < 1000); ++i) step(i);
  const double first_ms = times.first_ms;
  times = Times();
  times.first_ms = first_ms;
  const Stopwatch running;
  for (int i = 0; i < settings.repeats || (i % 2 == 1 && i < settings.repeats + 1); ++i) {
    if (i > 4 && running.elapsedMs() > kMostMs) break;
    step(i);
  }
  all_equal = all_equal && equal;
  std::printf("| %s | %zu | %g | %s, %s |", moving.name.c_str(), moving.scene.triangleCount(),
              margin_m, detector->backend().c_str(), toString(margin));
  times.print();
  const bool is_compared = options.nearest && !expected.empty();
  const char* const verdict = !is_compared ? "-" : equal ? "equal" : "DIFFERENT";
  std::printf(" %.9g | %zu | %s |\n", distance_m, contacts, verdict);
  std::fflush(stdout);
}

#ifdef DCM_HAVE_FCL
// Prints FCL's times and its distances in both states beside the true ones.
void measureFcl(const Settings& settings, MovingScene moving, FclTree tree) {
  constexpr double kMostMs = 4000;
  Options options;
  options.nearest = true;
  moving.scene.setMargin(0, 10);
  double expected_m[2];
  const auto exact = makeDetector(BackendChoice::kCpu);
  for (int i = 0; i < 2; ++i) {
    moving.show(i);
    expected_m[i] = leastOf(exact->detect(moving.scene, options).nearest);
  }
  Times times;
  double found_m[2] = {0, 0};
  Stopwatch watch;
  FclDistance fcl(moving.scene, tree);
  times.first_ms = watch.elapsedMs();
  const Stopwatch running;
  for (int i = 0; i < settings.repeats && (i < 3 || running.elapsedMs() < kMostMs); ++i) {
    moving.show(i);
    watch = Stopwatch();
    const double before_ms = processorMs();
    found_m[i % 2] = fcl.leastDistance(moving.scene, {0});
    times.processor.push_back(processorMs() - before_ms);
    times.whole.push_back(watch.elapsedMs());
  }
  const bool right = std::fabs(found_m[0] - expected_m[0]) <= 1e-5 * expected_m[0] &&
                     std::fabs(found_m[1] - expected_m[1]) <= 1e-5 * expected_m[1];
  const char* const what[] = {"rebuilt", "refitted bottom-up", "refitted top-down"};
  std::printf("| %s | %zu | inf | FCL, tree %s |", moving.name.c_str(),
              moving.scene.triangleCount(), what[static_cast<int>(tree)]);
  times.print();
  std::printf(" %.9g, %.9g | - | %s (%.9g, %.9g) |\n", found_m[0], found_m[1],
              right ? "right" : "WRONG", expected_m[0], expected_m[1]);
  std::fflush(stdout);
}
#endif

void printScene(const Settings& settings, const MovingScene& moving,
                const std::vector<float>& margins_m, bool with_fcl) {
  if (moving.name.find(settings.only) == std::string::npos) return;
  const BothStates expected = expectedOf(moving);
  measure(settings, moving, 0, Margin::kNone, expected);
  for (const float margin_m : margins_m) {
    measure(settings, moving, margin_m, Margin::kNearest, expected);
  }
  measure(settings, moving, margins_m.front(), Margin::kNearestNewTopology, expected);
#ifdef DCM_HAVE_FCL
  if (!with_fcl || settings.backend != BackendChoice::kCpu) return;
  for (const FclTree tree : {FclTree::kRebuilt, FclTree::kRefitBottomUp, FclTree::kRefitTopDown}) {
    measureFcl(settings, moving, tree);
  }
#else
  static_cast<void>(with_fcl);
#endif
}

int run(const Settings& settings) {
  std::printf(
      "| scene | triangles | margin m | what | first ms | processor ms | median | least | p95 | "
      "round trip | "
      "detect | distance m | contacts | nearest pairs |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  const std::vector<float> margins_m = {0.1F, 2, 10};
  for (const int n : {100, 215, 707}) {  // 20 000, 92 450, 999 698 triangles
    printScene(settings, handOverCloth(n, 0), margins_m, true);
    printScene(settings, handOverCloth(n, 0.02F), margins_m, true);
  }
  printScene(settings, pandaAndBall("Panda beside cloth_ball92", 0.68), {0.2F, 2}, true);
  printScene(settings, pandaAndBall("Panda touching cloth_ball92", 0.5), {0.2F, 2}, true);
  std::printf("\n%s\n", all_equal ? "All nearest pairs that were compared are equal."
                                  : "SOME NEAREST PAIRS ARE DIFFERENT.");
  return all_equal ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

// distance_benchmark [cpu|cuda] [REPEATS] [PART OF A SCENE'S NAME]
int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  dcm::Settings settings;
  if (argc > 1 && std::string(argv[1]) == "cuda") settings.backend = dcm::BackendChoice::kCuda;
  if (argc > 2) settings.repeats = std::atoi(argv[2]);
  if (argc > 3) settings.only = argv[3];
  return dcm::runBenchmark("distance_benchmark", [&] { return dcm::run(settings); });
}
