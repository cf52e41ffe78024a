// Prints what scenes take on one device and on several: `partitions_benchmark 0,1 [NAME]`; or on
// one device, one partition after the other, as if there were so many: `partitions_benchmark alone
// 2 [NAME]`; and their stages: `partitions_benchmark stages 2 [NAME]`. Moving input, medians; sets
// are compared with the whole's in the same run.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh_file.h"
#include "cuda/cuda_detector.h"
#include "cuda/partitions/partition_bounds.h"
#include "cuda/partitions/partitioned_detector.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "test_data.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

bool all_equal = true;

// One body that moves between two states.
struct Moving {
  std::string name;
  Scene scene;
  std::vector<float> state[2];

  void step(int i) { scene.setVertices(0, state[i % 2].data(), state[i % 2].size() / 3); }
  // Even: then every detector that is timed sees state 0 first, by which triangles are grouped.
  int warmUp() const { return scene.triangleCount() > 2000000 ? 18 : 80; }
  int repeats() const { return scene.triangleCount() > 2000000 ? 8 : 60; }
};

struct Taken {
  std::vector<double> detect_ms, round_trip_ms;
  std::vector<TrianglePair> contacts;  // of state 0
  Counters counters;
  int cold = 0;  // cycles that started so

  void note(int i, const DetectionResult& result, double detect) {
    cold += result.started_cold ? 1 : 0;
    if (i % 2 == 1) return;
    detect_ms.push_back(detect);
    round_trip_ms.push_back(result.round_trip_ms);
  }
};

Taken take(Moving& moving, const CudaSettings& settings, const Options& options) {
  const auto detector = makeCudaDetector(settings);
  moving.scene.useMemory(detector->vertexMemory());
  Taken taken;
  for (int i = 0; i < moving.warmUp(); ++i) {
    moving.step(i);
    detector->detect(moving.scene, options);
  }
  for (int i = 0; i < 2 * moving.repeats(); ++i) {
    moving.step(i);
    const DetectionResult& result = detector->detect(moving.scene, options);
    taken.note(i, result, result.detect_ms);
    if (i == 0) {
      taken.contacts = result.contacts;
      taken.counters = result.counters;
    }
  }
  return taken;
}

void printRow(const Moving& moving, const Options& options, const Taken& one, const Taken& shared,
              const std::string& more) {
  const bool equal = one.contacts == shared.contacts;
  all_equal = all_equal && equal;
  std::printf(
      "| %s | %s | %zu | %zu | %.3f | %.3f | %.2f | %.3f | %.3f | %.2f | %s | %s%d cold |\n",
      moving.name.c_str(), options.adjacent == AdjacentPairs::kSkip ? "skip" : "beyond_shared",
      moving.scene.triangleCount(), one.contacts.size(), median(one.detect_ms),
      median(shared.detect_ms), median(shared.detect_ms) / median(one.detect_ms),
      median(one.round_trip_ms), median(shared.round_trip_ms),
      median(shared.round_trip_ms) / median(one.round_trip_ms), equal ? "equal" : "DIFFERENT",
      more.c_str(), shared.cold);
  std::fflush(stdout);
}

// Returns the work of all partitions together as a multiple of the work on the undivided scene.
std::string moreWork(const Taken& one, const Counters& shared) {
  std::ostringstream more;
  more.precision(3);
  more << "clustered x "
       << static_cast<double>(shared.clustered) / static_cast<double>(one.counters.clustered)
       << ", overlaps x "
       << static_cast<double>(shared.interval_overlaps) /
              static_cast<double>(one.counters.interval_overlaps)
       << "; ";
  return more.str();
}

void onDevices(Moving& moving, const Options& options, const std::vector<int>& devices) {
  CudaSettings settings;
  settings.device = devices.front();
  const Taken one = take(moving, settings, options);
  settings.devices = devices;
  settings.shared_from_triangles = 0;
  const Taken shared = take(moving, settings, options);
  printRow(moving, options, one, shared, moreWork(one, shared.counters));
}

// Prints the times of the stages: first of the whole scene, then of the first of `count`
// partitions.
void stages(Moving& moving, const Options& options, std::size_t count) {
  for (const std::size_t partitions : {std::size_t{1}, count}) {
    CudaSettings settings;
    settings.time_stages = true;
    const auto detector = makeCudaPartitionDetector(settings);
    PartitionBounds bounds;
    std::vector<std::pair<std::string, std::vector<double>>> times;
    for (int i = 0; i < 40; ++i) {
      moving.step(i);
      detector->setPartition(bounds.cut(moving.scene, partitions).front());
      const DetectionResult& result = detector->detect(moving.scene, options);
      times.resize(result.stages_ms.size());
      for (std::size_t s = 0; i >= 20 && s < times.size(); ++s) {
        times[s].first = result.stages_ms[s].first;
        times[s].second.push_back(result.stages_ms[s].second);
      }
    }
    std::printf("| %s, 1 of %zu |", moving.name.c_str(), partitions);
    for (const auto& [name, ms] : times) std::printf(" %s %.3f |", name.c_str(), median(ms));
    std::printf("\n");
  }
}

// Each cycle is as long as its longest partition.
void oneAfterTheOther(Moving& moving, const Options& options, std::size_t count) {
  const Taken one = take(moving, CudaSettings(), options);
  std::vector<std::unique_ptr<PartitionDetector>> detectors;
  for (std::size_t s = 0; s < count; ++s) {
    detectors.push_back(makeCudaPartitionDetector(CudaSettings()));
  }
  PartitionBounds bounds;
  Taken shared;
  std::vector<std::vector<double>> its_ms(count);
  const int first = moving.warmUp();
  for (int i = 0; i < first + 2 * moving.repeats(); ++i) {
    moving.step(i + first);
    const std::vector<ScenePartition> partitions = bounds.cut(moving.scene, count);
    std::vector<double> took_ms;
    DetectionResult longest;
    longest.round_trip_ms = 0;
    for (std::size_t s = 0; s < count; ++s) {
      detectors[s]->setPartition(partitions[s]);
      const DetectionResult& result = detectors[s]->detect(moving.scene, options);
      took_ms.push_back(result.detect_ms);
      longest.round_trip_ms = std::max(longest.round_trip_ms, result.round_trip_ms);
      longest.started_cold = longest.started_cold || result.started_cold;
      if (i >= first && i % 2 == first % 2) its_ms[s].push_back(result.detect_ms);
      if (i != first) continue;
      shared.contacts.insert(shared.contacts.end(), result.contacts.begin(), result.contacts.end());
      shared.counters.clustered += result.counters.clustered;
      shared.counters.interval_overlaps += result.counters.interval_overlaps;
    }
    bounds.note(took_ms);
    if (i >= first) {
      shared.note(i - first, longest, *std::max_element(took_ms.begin(), took_ms.end()));
    }
  }
  std::sort(shared.contacts.begin(), shared.contacts.end());
  std::ostringstream more;
  more.precision(3);
  for (const std::vector<double>& ms : its_ms) more << median(ms) << " ";
  more << "ms; " << moreWork(one, shared.counters);
  printRow(moving, options, one, shared, more.str());
}

Moving selfMoving(const std::string& name, const TriangleMesh& a, const TriangleMesh& b) {
  return {name, selfScene(a), {a.vertices, b.vertices}};
}

int run(int argc, char** argv) {
  const bool stages_alone = argc > 2 && argv[1] == std::string("stages");
  const bool alone = stages_alone || (argc > 2 && argv[1] == std::string("alone"));
  std::vector<int> devices;
  std::istringstream list(argc > 1 ? argv[1] : "0,1");
  for (std::string device; !alone && std::getline(list, device, ',');) {
    devices.push_back(std::atoi(device.c_str()));
  }
  const char* const only = argc > (alone ? 3 : 2) ? argv[alone ? 3 : 2] : "";
  const auto readMesh = [](const char* file) { return readMeshFile(testDataFile(file)); };
  const TriangleMesh ball92 = readMesh("cloth-ball/cloth_ball92.ply");
  const TriangleMesh ball93 = readMesh("cloth-ball/cloth_ball93.ply");
  std::printf(
      "| scene | adjacent | triangles | contacts | one: detect ms | shared | x | one: round "
      "trip ms | shared | x | sets | |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  const auto table = [&](Moving moving, AdjacentPairs adjacent) {
    Options options;
    options.adjacent = adjacent;
    if (stages_alone) {
      stages(moving, options, static_cast<std::size_t>(std::atoi(argv[2])));
    } else if (alone) {
      oneAfterTheOther(moving, options, static_cast<std::size_t>(std::atoi(argv[2])));
    } else {
      onDevices(moving, options, devices);
    }
  };
  const auto wanted = [&](const std::string& name) {
    return *only == 0 || name.find(only) != std::string::npos;
  };
  struct Size {
    const char* name;
    std::size_t triangles;
  };
  for (const Size& size : {Size{"10 M", 10000000U}, Size{"1 M", 1000000U}, Size{"ball92", 92230U},
                           Size{"300 k", 300000U}, Size{"180 k", 180000U}, Size{"60 k", 60000U},
                           Size{"30 k", 30000U}, Size{"10 k", 10000U}}) {
    if (!wanted(size.name)) continue;
    const TriangleMesh a = sizedTo(ball92, size.triangles), b = sizedTo(ball93, size.triangles);
    table(selfMoving(size.name, a, b), AdjacentPairs::kSkip);
    if (size.triangles == 92230U) {
      table(selfMoving(size.name, a, b), AdjacentPairs::kBeyondShared);
    }
  }
  if (wanted("split")) {
    table(selfMoving("split", splitThreeByThree(ball92), splitThreeByThree(ball93)),
          AdjacentPairs::kBeyondShared);
  }
  if (wanted("funnel")) {
    table(selfMoving("funnel", readMesh("cloth-funnel/227.ply"), readMesh("cloth-funnel/228.ply")),
          AdjacentPairs::kBeyondShared);
  }
  return all_equal ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runBenchmark("partitions_benchmark", [argc, argv] { return dcm::run(argc, argv); });
}
