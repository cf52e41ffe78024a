#include "core/cpu/cpu_detector.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <functional>

#include "core/cpu/assign.h"
#include "core/cpu/cluster.h"
#include "core/cpu/cycle_data.h"
#include "core/cpu/geometry.h"
#include "core/cpu/large.h"
#include "core/cpu/output.h"
#include "core/cpu/pose.h"
#include "core/cpu/prototypes.h"
#include "core/cpu/size_split.h"
#include "core/cpu/sweep.h"
#include "core/host_vertices.h"
#include "core/stages.h"
#include "core/stopwatch.h"

namespace deformable_contact_monitor {
namespace {

void sweepClusters(const CycleInput& input, CycleOutput& output) {
  tbb::enumerable_thread_specific<ClusterSweeper> sweepers(std::cref(input));
  tbb::parallel_for(std::size_t{0}, input.assignment.clusterCount(), [&](std::size_t g) {
    if (!input.limit.over()) sweepers.local().sweep(ClusterIndex(static_cast<std::uint32_t>(g)));
  });
  for (ClusterSweeper& sweeper : sweepers) output.take(sweeper.output());
}

// Stages that run at the same time on several threads share the wall time as their work was.
void addShares(const StageTimes& work, double wall_ms, StageTimes& times) {
  const double work_ms = work.totalMs();
  if (work_ms > 0) times.add(work, wall_ms / work_ms);
}

class CpuDetector : public Detector {
 public:
  explicit CpuDetector(const CpuSettings& settings) : settings_(settings) {}
  std::string backend() const override { return "cpu"; }
  void reset() override { tracker_.clear(); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override;

 private:
  void run(const Scene& scene, const Options& options);
  bool makeClusters(const Scene& scene, const Options& options, const CycleLimit& limit,
                    StageTimes& times);
  void findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                    StageTimes& times);
  void countClusters();
  void countPairs(const CycleOutput& output);

  CpuSettings settings_;
  WorkingSetBuilder builder_;
  WorkingSet set_;
  SizeSplit split_;
  PrototypeTracker tracker_;
  Prototypes prototypes_;
  ClusterAssigner assigner_;
  ClusterAssignment assignment_;
  DetectionResult result_;
};

const DetectionResult& CpuDetector::detect(const Scene& scene, const Options& options) {
  requireValid(options);
  requireInstant(options, backend());
  requireHostVertices(scene, backend());
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] { run(scene, options); });
  return result_;
}

void CpuDetector::run(const Scene& scene, const Options& options) {
  const Stopwatch cycle;
  const CycleLimit limit(options.limits);
  StageTimes times;
  result_.begin(scene, options, isGuaranteed(options));
  if (makeClusters(scene, options, limit, times)) findContacts(scene, options, limit, times);
  if (limit.wasOver()) result_.cutOff(limit.why());
  result_.stages_ms = times.byName();
  result_.round_trip_ms = cycle.elapsedMs();
  result_.detect_ms = times.totalMs() - times.of(Stage::kOutput);
}

// The stages ahead of the pairs; false if the limit was over.
bool CpuDetector::makeClusters(const Scene& scene, const Options& options, const CycleLimit& limit,
                               StageTimes& times) {
  if (limit.over()) return false;
  Stopwatch watch;
  builder_.build(scene, set_, result_.counters, limit);
  if (!limit.wasOver()) splitBySize(set_, split_, limit);
  times.add(Stage::kPose, watch.lapMs());
  if (limit.wasOver()) return false;
  result_.started_cold = tracker_.update(set_, split_, options, limit, prototypes_);
  times.add(Stage::kCluster, watch.lapMs());
  if (limit.wasOver()) return false;
  assigner_.assign(scene, set_, split_, prototypes_, options.overlap, assignment_, limit);
  times.add(Stage::kAssign, watch.lapMs());
  return !limit.wasOver();
}

void CpuDetector::findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                               StageTimes& times) {
  Stopwatch watch;
  const BodyGroups groups(scene);
  const std::vector<float> slack = scaledSlacks(scene, split_.scale);
  ContactRoom room(settings_.memory_limit_bytes, options.geometry);
  const CycleInput input{scene, set_, split_, assignment_, groups, slack, options, limit, &room};
  CycleOutput output(input);
  sweepClusters(input, output);
  addShares(output.work, watch.lapMs(), times);
  output.work = StageTimes();
  if (!limit.wasOver()) sweepLargeTriangles(input, output);
  addShares(output.work, watch.lapMs(), times);

  writeContacts(scene, set_, output.contacts, limit, result_);
  writeGeometry(scene, options, result_);
  countClusters();
  countPairs(output);
  times.add(Stage::kOutput, watch.lapMs());
}

void CpuDetector::countClusters() {
  Counters& counters = result_.counters;
  counters.clustered = split_.regular.size();
  counters.large = split_.large.size();
  counters.clusters = split_.regular.empty() ? 0 : assignment_.clusterCount();
  counters.cluster_entries = assignment_.members.size();
  for (std::size_t g = 0; g < assignment_.clusterCount(); ++g) {
    counters.largest_cluster = std::max<std::uint64_t>(
        counters.largest_cluster, assignment_.member_begin[g + 1] - assignment_.member_begin[g]);
  }
}

void CpuDetector::countPairs(const CycleOutput& output) {
  result_.counters.interval_overlaps = output.interval_overlaps;
  result_.counters.candidates = output.candidates;
  result_.counters.exact = output.exact;
  result_.counters.undecided = output.undecided;
}

}  // namespace

std::unique_ptr<Detector> makeCpuDetector(const CpuSettings& settings) {
  return std::make_unique<CpuDetector>(settings);
}

}  // namespace deformable_contact_monitor
