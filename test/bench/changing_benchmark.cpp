// Prints what first cycles cost, and cycles in which bodies change or a scene grows: the worst of
// 300 beside the median, of CUDA where there is a device. Pair sets are compared with another CPU
// detector's now and then.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/common/stopwatch.h"
#include "core/cpu_detector.h"
#include "core/mesh_file.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/cuda_error.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "test_data.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kWarmUp = 40, kCycles = 300, kCompareEach = 50;
constexpr int kEach = 10;  // cycles from one change to the next

bool all_equal = true;  // sets that were compared

std::unique_ptr<Detector> makeFastest() {
  try {
    return makeCudaDetector();
  } catch (const CudaError&) {
    return makeCpuDetector();
  }
}

Options with(AdjacentPairs adjacent) {
  Options options;
  options.adjacent = adjacent;
  return options;
}

std::string stagesOf(const DetectionResult& result) {
  std::string text;
  for (const auto& [name, ms] : result.stages_ms) {
    if (ms < 0.001) continue;
    text += (text.empty() ? "" : ", ") + name + " " + std::to_string(ms).substr(0, 5);
  }
  return text;
}

void printFirstOfProcess() {
  const Scene scene = pairScene(clothGrid(4, 1, 0, 0.1F), clothGrid(3, 1, 0, 0));
  const Stopwatch making;
  const auto detector = makeFastest();
  const double made_ms = making.elapsedMs();
  const double first_ms = detector->detect(scene).round_trip_ms;
  const double second_ms = detector->detect(scene).round_trip_ms;
  std::printf("The process's first detector: %.1f ms to make, first cycle %.2f ms, second %.3f\n\n",
              made_ms, first_ms, second_ms);
}

// Measures first cycles of new detectors. The scene's body 0 moves between two states.
void printFirstCycles(const std::string& name, const TriangleMesh& a, const TriangleMesh& b,
                      const Options& options) {
  constexpr int kRepeats = 9;
  std::vector<double> make, first, second, reset, warm;
  std::string stages;
  Scene scene = selfScene(a);
  const auto detect = [&](Detector& detector, int i) -> const DetectionResult& {
    const std::vector<float>& state = (i % 2 == 0 ? a : b).vertices;
    scene.setVertices(0, state.data(), state.size() / 3);
    return detector.detect(scene, options);
  };
  for (int k = 0; k < kRepeats; ++k) {
    scene = selfScene(a);
    const Stopwatch making;
    const auto detector = makeFastest();
    make.push_back(making.elapsedMs());
    scene.useMemory(detector->vertexMemory());
    const DetectionResult& result = detect(*detector, 0);
    first.push_back(result.round_trip_ms);
    stages = stagesOf(result);
    second.push_back(detect(*detector, 1).round_trip_ms);
    for (int i = 2; i < 20; ++i) warm.push_back(detect(*detector, i).round_trip_ms);
    detector->reset();
    reset.push_back(detect(*detector, 0).round_trip_ms);
  }
  std::printf("| %s | %s | %zu | %.2f | %.2f | %.2f | %.2f | %.3f | %.3f | %s |\n", name.c_str(),
              toString(options.adjacent), scene.triangleCount(), median(make), median(first),
              percentile(first, 1), median(second), median(reset), median(warm), stages.c_str());
  std::fflush(stdout);
}

// Changes a scene ahead of its cycle i.
using Change = std::function<void(Scene& scene, int i)>;

// Each time beside the median of those around it, for a scene that grows gets slower by right.
std::vector<double> ratios(const std::vector<double>& times_ms) {
  constexpr std::size_t kAround = 15;
  std::vector<double> found;
  for (std::size_t i = 0; i < times_ms.size(); ++i) {
    const std::size_t first = i < kAround ? 0 : i - kAround;
    const std::size_t last = std::min(times_ms.size(), i + kAround + 1);
    found.push_back(times_ms[i] /
                    median(std::vector<double>(times_ms.begin() + first, times_ms.begin() + last)));
  }
  return found;
}

void printChanges(const std::string& name, Scene scene, const Change& change,
                  const Options& options) {
  const auto detector = makeFastest(), reference = makeCpuDetector();
  scene.useMemory(detector->vertexMemory());
  std::vector<double> times_ms;
  std::vector<std::string> stages;
  std::size_t cold = 0, first_contacts = 0, last_contacts = 0, first_triangles = 0;
  bool equal = true;
  for (int i = -kWarmUp; i < kCycles; ++i) {
    if (i == 0) first_triangles = scene.triangleCount();
    change(scene, i);
    const DetectionResult& result = detector->detect(scene, options);
    if (i < 0) continue;
    times_ms.push_back(result.round_trip_ms);
    stages.push_back(stagesOf(result));
    cold += result.started_cold ? 1 : 0;
    last_contacts = result.contacts.size();
    if (i == 0) first_contacts = last_contacts;
    if (i % kCompareEach != kCompareEach - 1 && i % kCompareEach != 0) continue;
    equal = equal && result.contacts == reference->detect(scene, options).contacts;
  }
  all_equal = all_equal && equal;
  const std::vector<double> all = ratios(times_ms);
  const auto worst = std::max_element(all.begin(), all.end()) - all.begin();
  std::printf("| %s | %s | %zu to %zu | %zu to %zu | %.3f | %.2f | %.2f | %.3f | %zu | %s | %s |\n",
              name.c_str(), toString(options.adjacent), first_triangles, scene.triangleCount(),
              first_contacts, last_contacts, median(times_ms), percentile(all, 0.95), all[worst],
              times_ms[worst], cold, equal ? "equal" : "DIFFERENT",
              ("cycle " + std::to_string(worst) + ": " + stages[worst]).c_str());
  std::fflush(stdout);
}

bool isTurn(int i) { return (i + kWarmUp) % kEach == 0; }

// A cloth that moves between two states, looked at for contacts with itself and with a small one.
struct ClothScenes {
  TriangleMesh a, b;

  Scene scene() const {
    Scene scene = selfScene(a);
    scene.addBody("small", clothGrid(20, 0.3F, 0, 0.02F));
    scene.setPairEnabled(0, 1, true);
    return scene;
  }
  void move(Scene& scene, int i) const {
    const std::vector<float>& state = (i % 2 == 0 ? a : b).vertices;
    scene.setVertices(0, state.data(), state.size() / 3);
  }
  void switchSmall(Scene& scene, int i) const {
    move(scene, i);
    if (isTurn(i)) scene.setPairEnabled(0, 1, !scene.pairEnabled(0, 1));
  }
  void remeshSmall(Scene& scene, int i) const {
    move(scene, i);
    if (isTurn(i)) scene.setMesh(1, clothGrid(10 + (i + kWarmUp) / kEach % 7, 0.3F, 0, 0.02F));
  }
  void addSmall(Scene& scene, int i) const {
    move(scene, i);
    if (!isTurn(i)) return;
    const BodyId id =
        scene.addBody("another", clothGrid(15, 0.3F, 1e-3F * static_cast<float>(i), 0.02F));
    scene.setPairEnabled(0, id, true);
  }
  // Another triangle less each time.
  void remeshLarge(Scene& scene, int i) const {
    if (!isTurn(i)) return move(scene, i);
    TriangleMesh mesh = i % 20 == 0 ? a : b;
    mesh.triangles.resize(mesh.triangles.size() - 3 * static_cast<std::size_t>(i + kWarmUp + 1));
    scene.setMesh(0, mesh);
  }
};

// The first n triangles and the vertices they need, a hundredth more each cycle.
Change growing(const TriangleMesh& mesh) {
  return [mesh](Scene& scene, int i) {
    const double whole = static_cast<double>(mesh.triangleCount());
    const auto n = static_cast<std::size_t>(whole * std::pow(1.01, i - kCycles));
    TriangleMesh part;
    part.triangles.assign(mesh.triangles.begin(), mesh.triangles.begin() + 3 * n);
    const std::uint32_t last = *std::max_element(part.triangles.begin(), part.triangles.end());
    part.vertices.assign(mesh.vertices.begin(), mesh.vertices.begin() + 3 * (last + 1));
    scene.setMesh(0, std::move(part));
  };
}

// Two cloths, of which one moves into the other: a hundredth further each cycle.
void moveInto(Scene& scene, int i) {
  const std::vector<float>& xyz = scene.body(0).mesh.vertices;
  float low = INFINITY, high = -INFINITY;
  for (std::size_t k = 0; k < xyz.size(); k += 3) {
    low = std::min(low, xyz[k]);
    high = std::max(high, xyz[k]);
  }
  RigidTransform pose;
  pose.translation[0] = (high - low) * (1 - 0.9 * std::pow(1.01, i - kCycles));
  scene.setPose(1, pose);
}

void printAllChanges(const ClothScenes& cloths, const Options& options) {
  const auto print = [&](const char* name, void (ClothScenes::*change)(Scene&, int) const) {
    printChanges(
        name, cloths.scene(), [&](Scene& scene, int i) { (cloths.*change)(scene, i); }, options);
  };
  print("cloth_ball, nothing but motion", &ClothScenes::move);
  print("a small body comes and goes", &ClothScenes::switchSmall);
  print("a small body is remeshed", &ClothScenes::remeshSmall);
  print("small bodies are added", &ClothScenes::addSmall);
  print("the cloth is remeshed", &ClothScenes::remeshLarge);
  printChanges("a cloth grows by 1 % a cycle", selfScene(cloths.a), growing(cloths.a), options);
}

// `only_first`: cycles of new detectors alone.
int run(bool only_first) {
  const auto read = [](const char* file) { return readMeshFile(testDataFile(file)); };
  const ClothScenes cloths{read("cloth-ball/cloth_ball92.ply"),
                           read("cloth-ball/cloth_ball93.ply")};
  printFirstOfProcess();
  std::printf(
      "| first cycles: scene | adjacent | triangles | detector ms | first ms | worst of 9 | "
      "second | after reset() | warm | stages of the first |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|\n");
  constexpr int kSide = 270;
  const TriangleMesh grid = clothGrid(kSide, 1, 0, 0.1F), later = clothGrid(kSide, 1, 0, 0.11F);
  for (const AdjacentPairs adjacent : {AdjacentPairs::kSkip, AdjacentPairs::kBeyondShared}) {
    printFirstCycles("cloth_ball92", cloths.a, cloths.b, with(adjacent));
    printFirstCycles("a waving cloth", grid, later, with(adjacent));
  }
  if (only_first) return 0;
  std::printf(
      "\n| changes | adjacent | triangles | contacts | median ms | p95 / median | worst / "
      "median around | its ms | cold | sets | the worst |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|\n");
  printAllChanges(cloths, with(AdjacentPairs::kBeyondShared));
  printAllChanges(cloths, with(AdjacentPairs::kSkip));
  const TriangleMesh split = splitThreeByThree(cloths.a);
  for (const AdjacentPairs adjacent : {AdjacentPairs::kBeyondShared, AdjacentPairs::kSkip}) {
    printChanges("a large cloth grows", selfScene(split), growing(split), with(adjacent));
  }
  printChanges("contacts grow", pairScene(cloths.a, cloths.a), moveInto,
               with(AdjacentPairs::kSkip));
  return all_equal ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runBenchmark("changing_benchmark",
                           [&] { return dcm::run(argc > 1 && std::string(argv[1]) == "first"); });
}
