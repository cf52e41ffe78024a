#include "core/cpu_detector.h"

#include <algorithm>
#include <atomic>
#include <tuple>

#include "core/bounds/distance_search.h"
#include "core/bounds/radii.h"
#include "core/common/contact_geometry.h"
#include "core/common/guarded_detector.h"
#include "core/common/parallel.h"
#include "core/common/scene_queries.h"
#include "core/common/stages.h"
#include "core/common/stopwatch.h"
#include "core/cpu/assign.h"
#include "core/cpu/cluster.h"
#include "core/cpu/fans.h"
#include "core/cpu/output.h"
#include "core/cpu/pair_stages.h"
#include "core/cpu/size_split.h"
#include "core/cpu/sweep.h"
#include "core/cpu/transform.h"

namespace deformable_contact_monitor {
namespace {

// Orders clusters by size, the largest first, so that no thread begins a large one when the others
// are done.
template <class Primitive>
std::vector<ClusterIndex> clustersBySize(const ClusterAssignment<Primitive>& assignment) {
  std::vector<ClusterIndex> clusters;
  for (std::uint32_t g = 0; g < assignment.clusterCount(); ++g) clusters.emplace_back(g);
  const auto size = [&assignment](ClusterIndex g) {
    return assignment.entry_begin[g.value + 1] - assignment.entry_begin[g.value];
  };
  std::sort(clusters.begin(), clusters.end(), [&size](ClusterIndex a, ClusterIndex b) {
    return size(a) != size(b) ? size(a) > size(b) : a < b;
  });
  return clusters;
}

// Sweeps all clusters. Each thread takes the next cluster until none is left.
template <class Primitive>
void sweepClusters(const CycleInput<Primitive>& input,
                   std::vector<SweepBuffers<Primitive>>& buffers, CycleOutput<Primitive>& output) {
  const std::vector<ClusterIndex> clusters = clustersBySize(input.assignment);
  std::vector<CycleOutput<Primitive>> outputs(std::min(threadCount(), clusters.size()),
                                              CycleOutput<Primitive>(input));
  if (buffers.size() < outputs.size()) buffers.resize(outputs.size());
  std::atomic<std::size_t> next{0};
  parallelBlocks(outputs.size(), 1, [&](std::size_t thread, std::size_t, std::size_t) {
    ClusterSweeper<Primitive> sweeper(input, buffers[thread], outputs[thread]);
    for (std::size_t i = next++; i < clusters.size() && !input.limit.over(); i = next++) {
      sweeper.sweep(clusters[i]);
    }
  });
  for (CycleOutput<Primitive>& part : outputs) output.take(part);
}

// Adds the times of stages that run at the same time on several threads: each gets its part of the
// wall time.
void addShares(const StageTimes& work, double wall_ms, StageTimes& times) {
  const double work_ms = work.totalMs();
  if (work_ms > 0) times.add(work, wall_ms / work_ms);
}

// Buffers that each cycle overwrites, and caches that are keyed by the revisions of bodies, so that
// they serve every scene. Detectors of a pool share one of these.
struct CycleArrays {
  WorkingSetBuilder builder;
  WorkingSet set;
  FanCertifier fans;
  SizeSplit split;
  Prototypes prototypes;
  ClusterAssigner assigner;
  std::tuple<ClusterAssignment<Triangle>, ClusterAssignment<MovingTriangle>> assignments;
  std::tuple<std::vector<SweepBuffers<Triangle>>, std::vector<SweepBuffers<MovingTriangle>>>
      sweep_buffers;
  std::tuple<ContactWriter<Triangle>, ContactWriter<MovingTriangle>> writers;
  PairRounds rounds;
  DetectionResult result;
};

// The CPU backend. detect() runs the stages one after the other. What it keeps for itself is of use
// to its own set of pairs alone.
class CpuDetector : public Detector {
 public:
  CpuDetector(const CpuSettings& settings, std::shared_ptr<CycleArrays> arrays)
      : settings_(settings),
        arrays_(std::move(arrays)),
        distances_(settings.tilings ? settings.tilings : std::make_shared<TilingCache>()) {}
  std::string backend() const override { return "cpu"; }
  void reset() override {
    tracker_.clear();
    distances_.forget();
  }
  void swapResult(DetectionResult& result) override { arrays_->result.swap(result); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override;

 private:
  template <class Primitive>
  void run(const Scene& scene, const Options& options);
  template <class Primitive>
  bool makeClusters(const Scene& scene, const Options& options, const CycleLimit& limit,
                    StageTimes& times);
  template <class Primitive>
  void findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                    StageTimes& times);
  template <class Primitive>
  void countClusters();
  template <class Primitive>
  ClusterAssignment<Primitive>& assignment() {
    return std::get<ClusterAssignment<Primitive>>(arrays_->assignments);
  }

  CpuSettings settings_;
  Threads threads_;
  const std::shared_ptr<CycleArrays> arrays_;
  PrototypeTracker tracker_;
  std::vector<NearestPrototype> nearest_;
  DistanceSearch distances_;
};

const DetectionResult& CpuDetector::detect(const Scene& scene, const Options& options) {
  requireValid(options);
  requireHostVertices(scene, backend());
  threads_.run(options.threads, [&] {
    if (options.motion == Motion::kSwept) {
      run<MovingTriangle>(scene, options);
    } else {
      run<Triangle>(scene, options);
    }
  });
  return arrays_->result;
}

// Runs all stages on triangles at one moment, or on moving ones.
template <class Primitive>
void CpuDetector::run(const Scene& scene, const Options& options) {
  const Stopwatch cycle;
  const CycleLimit limit(options.limits);
  StageTimes times;
  arrays_->result.begin(scene, options, isGuaranteed(options));
  if (makeClusters<Primitive>(scene, options, limit, times)) {
    findContacts<Primitive>(scene, options, limit, times);
  }
  Stopwatch watch;
  distances_.find(scene, options, limit, arrays_->rounds, arrays_->result);
  const double nearest_ms = watch.lapMs();
  if (limit.wasOver()) arrays_->result.cutOff(limit.why());
  arrays_->result.stages_ms = times.byName();
  if (options.nearest) arrays_->result.stages_ms.emplace_back("nearest", nearest_ms);
  arrays_->result.round_trip_ms = cycle.elapsedMs();
  arrays_->result.detect_ms = times.totalMs() - times.of(Stage::kOutput) + nearest_ms;
}

// Runs the stages before pairs come up. Returns false if the limit is over.
template <class Primitive>
bool CpuDetector::makeClusters(const Scene& scene, const Options& options, const CycleLimit& limit,
                               StageTimes& times) {
  if (limit.over()) return false;
  Stopwatch watch;
  arrays_->builder.build<Primitive>(scene, options, arrays_->set, arrays_->result.counters, limit);
  arrays_->result.rejected_parts = arrays_->builder.rejectedParts();
  if (!kIsMoving<Primitive> && options.adjacent == AdjacentPairs::kBeyondShared &&
      options.predicates != Predicates::kConservative && !limit.wasOver()) {
    arrays_->fans.certify(scene, arrays_->set, limit);
  }
  if (!limit.wasOver()) splitBySize(arrays_->set, arrays_->split, limit);
  times.add(Stage::kTransform, watch.lapMs());
  if (limit.wasOver()) return false;
  arrays_->result.started_cold =
      tracker_.update<Primitive>(arrays_->set, arrays_->split, options, limit, arrays_->prototypes);
  times.add(Stage::kCluster, watch.lapMs());
  if (limit.wasOver()) return false;
  arrays_->assigner.assign(scene, arrays_->set, arrays_->split, arrays_->prototypes, options,
                           nearest_, assignment<Primitive>(), limit);
  times.add(Stage::kAssign, watch.lapMs());
  return !limit.wasOver();
}

// Runs the stages that find, decide and list pairs.
template <class Primitive>
void CpuDetector::findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                               StageTimes& times) {
  Stopwatch watch;
  const BodyGroups groups(scene);
  const std::vector<float> slack = scaledSlacks<Primitive>(scene, options, arrays_->split.scale);
  ContactRoom room(settings_.memory_limit_bytes,
                   ContactRoom::bytesEach<Primitive>(options.geometry));
  const CycleInput<Primitive> input{scene,  arrays_->set, arrays_->split, assignment<Primitive>(),
                                    groups, slack,        options,        limit,
                                    &room};
  CycleOutput<Primitive> output(input);
  sweepClusters(input, std::get<std::vector<SweepBuffers<Primitive>>>(arrays_->sweep_buffers),
                output);
  addShares(output.work, watch.lapMs(), times);
  output.work = StageTimes();
  if (!limit.wasOver()) sweepOversized(input, output);
  addShares(output.work, watch.lapMs(), times);

  std::get<ContactWriter<Primitive>>(arrays_->writers)
      .write(scene, options, arrays_->set, output.contacts, limit, arrays_->result);
  writeGeometry(scene, options, arrays_->result);
  countClusters<Primitive>();
  arrays_->result.counters.addWork(output.counters);
  times.add(Stage::kOutput, watch.lapMs());
}

// Fills in the counters of clusters.
template <class Primitive>
void CpuDetector::countClusters() {
  const ClusterAssignment<Primitive>& assignment = this->assignment<Primitive>();
  Counters& counters = arrays_->result.counters;
  counters.clustered = arrays_->split.regular.size();
  counters.large = arrays_->split.oversized.size();
  counters.clusters = arrays_->split.regular.empty() ? 0 : assignment.clusterCount();
  counters.cluster_entries = assignment.entries.size();
  for (std::size_t g = 0; g < assignment.clusterCount(); ++g) {
    counters.largest_cluster = std::max<std::uint64_t>(
        counters.largest_cluster, assignment.entry_begin[g + 1] - assignment.entry_begin[g]);
  }
}

}  // namespace

std::unique_ptr<Detector> makeCpuDetector(const CpuSettings& settings) {
  return cpuDetectorMaker(settings)();
}

std::function<std::unique_ptr<Detector>()> cpuDetectorMaker(const CpuSettings& settings) {
  return [settings, arrays = std::make_shared<CycleArrays>()] {
    return guardAgainstForks(
        withRadiiAndPartMargins(std::make_unique<CpuDetector>(settings, arrays)),
        AfterFork::kWorks);
  };
}

}  // namespace deformable_contact_monitor
