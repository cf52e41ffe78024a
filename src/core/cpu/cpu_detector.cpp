#include "core/cpu/cpu_detector.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <functional>

#include "core/cpu/fuzzy_clustering.h"
#include "core/cpu/large.h"
#include "core/cpu/pose.h"
#include "core/cpu/prototypes.h"
#include "core/cpu/size_split.h"
#include "core/cpu/sweep.h"
#include "core/rules/cluster_count.h"

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration d) {
  return std::chrono::duration<double, std::milli>(d).count();
}

constexpr ClusterCountPolicy kClusterCounts{1000, 2048, 600, 8};

class CpuDetector : public Detector {
 public:
  std::string backend() const override { return "cpu"; }
  void reset() override { prototypes_.clear(); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override;

 private:
  // Times the stages one after the other.
  class StageTimer {
   public:
    explicit StageTimer(DetectionResult& result) : result_(result), last_(Clock::now()) {}
    double lap() {
      const auto now = Clock::now();
      const double ms = milliseconds(now - last_);
      last_ = now;
      return ms;
    }
    void stage(const std::string& name) { result_.stages_ms.emplace_back(name, lap()); }

   private:
    DetectionResult& result_;
    Clock::time_point last_;
  };

  void run(const Scene& scene, const Options& options);
  void refreshPrototypes(const Options& options);
  void sweepClusters(const SweepInput& input, SweepOutput& output);
  void publish(const Scene& scene, std::vector<WorkingContact>& contacts);

  WorkingSetBuilder builder_;
  WorkingSet set_;
  SizeSplit split_;
  std::vector<Vec3d> prototypes_;  // scene frame [m], from cycle to cycle
  int cycles_since_refresh_ = 0;
  Prototypes searchable_;
  ClusterAssigner assigner_;
  ClusterAssignment assignment_;
  std::vector<std::uint32_t> first_of_;
  DetectionResult result_;
};

const DetectionResult& CpuDetector::detect(const Scene& scene, const Options& options) {
  requireValid(options);
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] { run(scene, options); });
  return result_;
}

// Fuzzy c-means on centroids evenly spread over the order of the triangles, from last cycle's
// prototypes if there are as many as wanted.
void CpuDetector::refreshPrototypes(const Options& options) {
  const std::size_t count =
      clusterCountFor(options, kClusterCounts, split_.regular.size(), prototypes_.size());
  const bool cold = prototypes_.size() != count;
  std::vector<Vec3f> scaled;
  for (const Vec3d& p : prototypes_) {
    const Vec3d s = split_.scale.applyExact(p);
    scaled.push_back({static_cast<float>(s.x), static_cast<float>(s.y), static_cast<float>(s.z)});
  }
  if (count <= 1) {
    scaled.assign(1, Vec3f());
  } else if (cold || ++cycles_since_refresh_ >= options.refresh_period) {
    cycles_since_refresh_ = 0;
    const std::size_t wanted = std::max<std::size_t>(2048, 8 * count);
    const std::size_t samples = std::min(split_.regular.size(), wanted);
    std::vector<Vec3f> centroids(samples);
    for (std::size_t i = 0; i < samples; ++i) {
      const std::uint32_t t = split_.regular[i * split_.regular.size() / samples];
      const Triangle posed = set_.posed(t);
      Vec3d sum;
      for (const Vec3f& v : posed.v) sum = sum + split_.scale.applyExact(toDouble(v));
      centroids[i] = {static_cast<float>(sum.x / 3), static_cast<float>(sum.y / 3),
                      static_cast<float>(sum.z / 3)};
    }
    FuzzyClustering clustering(options.fuzzifier);
    constexpr int kColdIterations = 5;
    if (cold) {
      clustering.initialise(centroids, count);
    } else {
      clustering.setPrototypes(std::move(scaled));
    }
    for (int i = 0; i < options.iterations * (cold ? kColdIterations : 1); ++i) {
      clustering.iterate(centroids);
    }
    scaled = clustering.prototypes();
  }
  prototypes_.clear();
  for (const Vec3f& p : scaled) prototypes_.push_back(split_.scale.invert(p));
  searchable_.build(scaled);
}

void CpuDetector::sweepClusters(const SweepInput& input, SweepOutput& output) {
  tbb::enumerable_thread_specific<ClusterSweeper> sweepers(std::cref(input));
  tbb::parallel_for(std::size_t{0}, input.assignment.clusterCount(),
                    [&](std::size_t g) { sweepers.local().sweep(static_cast<std::uint32_t>(g)); });
  for (ClusterSweeper& sweeper : sweepers) output.add(sweeper.output());
}

// Sorted by working-set index, which is sorted by (body, triangle).
void CpuDetector::publish(const Scene& scene, std::vector<WorkingContact>& contacts) {
  first_of_.assign(set_.size() + 1, 0);
  for (const WorkingContact& c : contacts) ++first_of_[c.a + 1];
  for (std::size_t i = 0; i < set_.size(); ++i) first_of_[i + 1] += first_of_[i];
  std::vector<WorkingContact> sorted(contacts.size());
  std::vector<std::uint32_t> next(first_of_.begin(), first_of_.end() - 1);
  for (const WorkingContact& c : contacts) sorted[next[c.a]++] = c;
  for (std::size_t i = 0; i < set_.size(); ++i) {
    std::sort(sorted.begin() + first_of_[i], sorted.begin() + first_of_[i + 1],
              [](const WorkingContact& x, const WorkingContact& y) { return x.b < y.b; });
  }
  const bool margins = std::any_of(scene.bodies().begin(), scene.bodies().end(),
                                   [](const Body& body) { return body.margin_m > 0; });
  result_.contacts.resize(sorted.size());
  result_.separations_m.resize(margins ? sorted.size() : 0);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const WorkingContact& c = sorted[i];
    result_.contacts[i] = {set_.body[c.a], set_.triangle[c.a], set_.body[c.b], set_.triangle[c.b]};
    if (margins) result_.separations_m[i] = c.separation_m;
  }
}

void CpuDetector::run(const Scene& scene, const Options& options) {
  const auto start = Clock::now();
  Counters& counters = result_.counters;
  counters = Counters();
  result_.stages_ms.clear();
  result_.guaranteed = options.overlap == 1 && options.predicates != Predicates::kFast;
  StageTimer timer(result_);

  builder_.build(scene, set_, counters);
  timer.stage("cull");
  splitBySize(set_, split_);
  timer.stage("split");
  refreshPrototypes(options);
  timer.stage("cluster");
  assigner_.assign(scene, set_, split_, searchable_, options.overlap, assignment_);
  timer.stage("assign");

  const BodyGroups groups(scene);
  const std::vector<float> slack = scaledSlack(scene, split_.scale);
  const SweepInput input{scene, set_, split_, assignment_, groups, slack, options};
  SweepOutput output;
  sweepClusters(input, output);
  // On several threads the three overlap: split the wall time as their work was.
  const double work_ms = output.sort_ms + output.sweep_ms + output.narrow_ms;
  const double share = work_ms > 0 ? timer.lap() / work_ms : 0;
  result_.stages_ms.emplace_back("sort", output.sort_ms * share);
  result_.stages_ms.emplace_back("sweep", output.sweep_ms * share);
  result_.stages_ms.emplace_back("narrow", output.narrow_ms * share);
  sweepLargeTriangles(input, output);
  timer.stage("large");
  result_.detect_ms = milliseconds(Clock::now() - start);

  publish(scene, output.contacts);
  timer.stage("output");
  counters.clustered = split_.regular.size();
  counters.large = split_.large.size();
  counters.clusters = split_.regular.empty() ? 0 : assignment_.clusterCount();
  counters.cluster_entries = assignment_.members.size();
  for (std::size_t g = 0; g < assignment_.clusterCount(); ++g) {
    counters.largest_cluster = std::max<std::uint64_t>(
        counters.largest_cluster, assignment_.member_begin[g + 1] - assignment_.member_begin[g]);
  }
  counters.interval_overlaps = output.interval_overlaps;
  counters.candidates = output.candidates;
  counters.exact = output.exact;
  counters.undecided = output.undecided;
  result_.round_trip_ms = milliseconds(Clock::now() - start);
}

}  // namespace

std::unique_ptr<Detector> makeCpuDetector() { return std::make_unique<CpuDetector>(); }

}  // namespace deformable_contact_monitor
