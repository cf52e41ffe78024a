#include "core/cpu_detector.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <tuple>

#include "core/common/host_vertices.h"
#include "core/common/parallel.h"
#include "core/common/stages.h"
#include "core/common/stopwatch.h"
#include "core/cpu/assign.h"
#include "core/cpu/cluster.h"
#include "core/cpu/cycle_data.h"
#include "core/cpu/fans.h"
#include "core/cpu/geometry.h"
#include "core/cpu/output.h"
#include "core/cpu/oversized.h"
#include "core/cpu/prototypes.h"
#include "core/cpu/size_split.h"
#include "core/cpu/sweep.h"
#include "core/cpu/transform.h"

namespace deformable_contact_monitor {
namespace {

// Large ones first, for no thread should begin one when the others are done.
template <class Hull>
std::vector<ClusterIndex> clustersBySize(const ClusterAssignment<Hull>& assignment) {
  std::vector<ClusterIndex> clusters;
  for (std::uint32_t g = 0; g < assignment.clusterCount(); ++g) clusters.emplace_back(g);
  const auto size = [&assignment](ClusterIndex g) {
    return assignment.member_begin[g.value + 1] - assignment.member_begin[g.value];
  };
  std::sort(clusters.begin(), clusters.end(), [&size](ClusterIndex a, ClusterIndex b) {
    return size(a) != size(b) ? size(a) > size(b) : a < b;
  });
  return clusters;
}

// Each thread takes the next cluster as long as there is one.
template <class Hull>
void sweepClusters(const CycleInput<Hull>& input, std::vector<SweepBuffers<Hull>>& buffers,
                   CycleOutput<Hull>& output) {
  const std::vector<ClusterIndex> clusters = clustersBySize(input.assignment);
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  std::vector<CycleOutput<Hull>> outputs(std::min(threads, clusters.size()),
                                         CycleOutput<Hull>(input));
  if (buffers.size() < outputs.size()) buffers.resize(outputs.size());
  std::atomic<std::size_t> next{0};
  parallelBlocks(outputs.size(), 1, [&](std::size_t thread, std::size_t, std::size_t) {
    ClusterSweeper<Hull> sweeper(input, buffers[thread], outputs[thread]);
    for (std::size_t i = next++; i < clusters.size() && !input.limit.over(); i = next++) {
      sweeper.sweep(clusters[i]);
    }
  });
  for (CycleOutput<Hull>& part : outputs) output.take(part);
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
  template <class Hull>
  void run(const Scene& scene, const Options& options);
  template <class Hull>
  bool makeClusters(const Scene& scene, const Options& options, const CycleLimit& limit,
                    StageTimes& times);
  template <class Hull>
  void findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                    StageTimes& times);
  template <class Hull>
  void countClusters();
  template <class Hull>
  void countPairs(const CycleOutput<Hull>& output);
  template <class Hull>
  ClusterAssignment<Hull>& assignment() {
    return std::get<ClusterAssignment<Hull>>(assignments_);
  }

  CpuSettings settings_;
  std::optional<tbb::task_arena> arena_;  // of so many threads, as of Options::threads
  int arena_threads_ = 0;
  WorkingSetBuilder builder_;
  WorkingSet set_;
  FanCertifier fans_;
  SizeSplit split_;
  PrototypeTracker tracker_;
  Prototypes prototypes_;
  ClusterAssigner assigner_;
  std::tuple<ClusterAssignment<Triangle>, ClusterAssignment<MovingTriangle>> assignments_;
  std::tuple<std::vector<SweepBuffers<Triangle>>, std::vector<SweepBuffers<MovingTriangle>>>
      sweep_buffers_;
  std::tuple<ContactWriter<Triangle>, ContactWriter<MovingTriangle>> writers_;
  DetectionResult result_;
};

const DetectionResult& CpuDetector::detect(const Scene& scene, const Options& options) {
  requireValid(options);
  requireHostVertices(scene, backend());
  if (!arena_ || arena_threads_ != options.threads) {
    int threads = tbb::task_arena::automatic;
    if (options.threads > 0) threads = options.threads;
    arena_.emplace(threads);
    arena_threads_ = options.threads;
  }
  arena_->execute([&] {
    if (options.motion == Motion::kSwept) {
      run<MovingTriangle>(scene, options);
    } else {
      run<Triangle>(scene, options);
    }
  });
  return result_;
}

template <class Hull>
void CpuDetector::run(const Scene& scene, const Options& options) {
  const Stopwatch cycle;
  const CycleLimit limit(options.limits);
  StageTimes times;
  result_.begin(scene, options, isGuaranteed(options));
  if (makeClusters<Hull>(scene, options, limit, times)) {
    findContacts<Hull>(scene, options, limit, times);
  }
  if (limit.wasOver()) result_.cutOff(limit.why());
  result_.stages_ms = times.byName();
  result_.round_trip_ms = cycle.elapsedMs();
  result_.detect_ms = times.totalMs() - times.of(Stage::kOutput);
}

// The stages ahead of the pairs; false if the limit was over.
template <class Hull>
bool CpuDetector::makeClusters(const Scene& scene, const Options& options, const CycleLimit& limit,
                               StageTimes& times) {
  if (limit.over()) return false;
  Stopwatch watch;
  builder_.build<Hull>(scene, set_, result_.counters, limit);
  if (!kIsMoving<Hull> && options.adjacent == AdjacentPairs::kBeyondShared &&
      options.predicates == Predicates::kExact && !limit.wasOver()) {
    fans_.certify(scene, set_, limit);
  }
  if (!limit.wasOver()) splitBySize(set_, split_, limit);
  times.add(Stage::kTransform, watch.lapMs());
  if (limit.wasOver()) return false;
  result_.started_cold = tracker_.update<Hull>(set_, split_, options, limit, prototypes_);
  times.add(Stage::kCluster, watch.lapMs());
  if (limit.wasOver()) return false;
  assigner_.assign(scene, set_, split_, prototypes_, options.overlap, assignment<Hull>(), limit);
  times.add(Stage::kAssign, watch.lapMs());
  return !limit.wasOver();
}

template <class Hull>
void CpuDetector::findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                               StageTimes& times) {
  Stopwatch watch;
  const BodyGroups groups(scene);
  const std::vector<float> slack = scaledSlacks<Hull>(scene, split_.scale);
  ContactRoom room(settings_.memory_limit_bytes, ContactRoom::bytesEach<Hull>(options.geometry));
  const CycleInput<Hull> input{scene,   set_,  split_, assignment<Hull>(), groups, slack,
                               options, limit, &room};
  CycleOutput<Hull> output(input);
  sweepClusters(input, std::get<std::vector<SweepBuffers<Hull>>>(sweep_buffers_), output);
  addShares(output.work, watch.lapMs(), times);
  output.work = StageTimes();
  if (!limit.wasOver()) sweepLargeTriangles(input, output);
  addShares(output.work, watch.lapMs(), times);

  std::get<ContactWriter<Hull>>(writers_).write(scene, options, set_, output.contacts, limit,
                                                result_);
  writeGeometry(scene, options, result_);
  countClusters<Hull>();
  countPairs(output);
  times.add(Stage::kOutput, watch.lapMs());
}

template <class Hull>
void CpuDetector::countClusters() {
  const ClusterAssignment<Hull>& assignment = this->assignment<Hull>();
  Counters& counters = result_.counters;
  counters.clustered = split_.regular.size();
  counters.large = split_.large.size();
  counters.clusters = split_.regular.empty() ? 0 : assignment.clusterCount();
  counters.cluster_entries = assignment.members.size();
  for (std::size_t g = 0; g < assignment.clusterCount(); ++g) {
    counters.largest_cluster = std::max<std::uint64_t>(
        counters.largest_cluster, assignment.member_begin[g + 1] - assignment.member_begin[g]);
  }
}

template <class Hull>
void CpuDetector::countPairs(const CycleOutput<Hull>& output) {
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
