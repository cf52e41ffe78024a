// Prints a table: the papers' rule for the clusters of a triangle, one radius for all, beside the
// half-space rule. All else, prototypes included, is the same.
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"
#include "core/cpu/cluster.h"
#include "core/cpu/fuzzy_clustering.h"
#include "core/cpu/pair_stages.h"
#include "core/cpu/sweep.h"
#include "core/mesh_file.h"
#include "global_radius.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "test_data.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

using Contacts = std::set<std::pair<std::uint32_t, std::uint32_t>>;
using Assign = std::function<ClusterAssignment<Triangle>(const SizeSplit&, const Prototypes&)>;

// The papers have no list of large triangles.
SizeSplit withoutLargeList(const WorkingSet& set, SizeSplit split) {
  split.regular.insert(split.regular.end(), split.oversized.begin(), split.oversized.end());
  std::sort(split.regular.begin(), split.regular.end());
  split.oversized.clear();
  double reach = 0;
  for (const Aabb& box : set.boxes) {
    for (const Vec3f& corner : {box.min, box.max}) {
      const Vec3d d = toDouble(corner) - split.scale.origin;
      reach = std::max({reach, std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
    }
  }
  split.scale.scale = std::ldexp(1.0, -(std::ilogb(reach) + 1));
  return split;
}

// As the CPU backend's, warmed up.
Prototypes prototypesOf(const WorkingSet& set, const SizeSplit& split, std::size_t count) {
  const std::vector<Vec3f> centroids =
      sampleCentroids(set, split,
                      samplingOf(static_cast<std::uint32_t>(split.regular.size()),
                                 static_cast<std::uint32_t>(count), 2048));
  FuzzyClustering clustering(Options().fuzzifier);
  clustering.initialise(centroids, count);
  for (int i = 0; i < 10; ++i) clustering.iterate(centroids);
  Prototypes prototypes;
  prototypes.build(clustering.prototypes());
  return prototypes;
}

struct Rule {
  const char* name;
  SizeSplit split;
  Assign assign;
};

// Prints a row; returns the contacts, to be compared.
Contacts measure(const Scene& scene, const char* name, const WorkingSet& set, const Rule& rule,
                 std::size_t count) {
  constexpr int kRepeats = 5;
  const Prototypes prototypes = prototypesOf(set, rule.split, count);
  const BodyGroups groups(scene);
  const std::vector<float> slack = scaledSlacks(scene, Options(), rule.split.scale);
  const Options options;
  std::vector<double> assign_ms, sweep_ms;
  SweepBuffers<Triangle> buffers;
  CycleOutput<Triangle> output;
  std::size_t entries = 0, largest = 0;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    Stopwatch watch;
    const ClusterAssignment<Triangle> assignment = rule.assign(rule.split, prototypes);
    assign_ms.push_back(watch.lapMs());
    const CycleInput<Triangle> input{scene, set, rule.split, assignment, groups, slack, options};
    output = CycleOutput<Triangle>(input);
    ClusterSweeper<Triangle> sweeper(input, buffers, output);
    for (std::uint32_t g = 0; g < assignment.clusterCount(); ++g) sweeper.sweep(ClusterIndex(g));
    sweepOversized(input, output);
    sweep_ms.push_back(watch.lapMs());
    entries = assignment.entries.size();
    for (std::uint32_t g = 0; g < assignment.clusterCount(); ++g) {
      largest =
          std::max<std::size_t>(largest, assignment.entry_begin[g + 1] - assignment.entry_begin[g]);
    }
  }
  Contacts contacts;
  for (const std::vector<WorkingContact<Triangle>>& block : output.contacts.blocks()) {
    for (const WorkingContact<Triangle>& c : block) contacts.emplace(c.a.value, c.b.value);
  }
  std::printf("| %s | %zu | %s | %.2f | %zu | %.1f | %.0f | %.0f | %zu |\n", name, count, rule.name,
              static_cast<double>(entries) / static_cast<double>(rule.split.regular.size()),
              largest, static_cast<double>(output.counters.interval_overlaps) * 1e-6,
              median(assign_ms), median(sweep_ms), contacts.size());
  std::fflush(stdout);
  return contacts;
}

void compareRules(const char* name, const Scene& scene, const std::vector<std::size_t>& counts) {
  WorkingSetBuilder builder;
  WorkingSet set;
  Counters counters;
  builder.build(scene, Options(), set, counters);
  SizeSplit split;
  splitBySize(set, split);
  ClusterAssigner assigner;
  const Rule rules[] = {
      {"one radius", withoutLargeList(set, split),
       [&set](const SizeSplit& s, const Prototypes& p) { return assignByGlobalRadius(set, s, p); }},
      {"half-spaces", split, [&](const SizeSplit& s, const Prototypes& p) {
         ClusterAssignment<Triangle> assignment;
         assigner.assign(scene, set, s, p, Options(), assignment);
         return assignment;
       }}};
  for (const std::size_t count : counts) {
    const auto by_radius = measure(scene, name, set, rules[0], count);
    if (by_radius != measure(scene, name, set, rules[1], count)) {
      throw std::runtime_error("the two rules find different contacts");
    }
  }
}

int run() {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  std::printf(
      "| scene | clusters | rule | clusters a triangle | largest cluster | interval overlaps [M] | "
      "assign [ms] | sort, sweep, judge [ms] | contacts "
      "|\n|---|---|---|---|---|---|---|---|---|\n");
  TriangleMesh cloth = readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply"));
  compareRules("cloth_ball92", selfScene(cloth), {16, 64, 256, 1024});

  const auto [least, most] = std::minmax_element(cloth.vertices.begin(), cloth.vertices.end());
  const float size = 50 * (*most - *least);
  float floor = *most;
  for (std::size_t i = 1; i < cloth.vertices.size(); i += 3) {
    floor = std::min(floor, cloth.vertices[i]);
  }
  const auto first = static_cast<std::uint32_t>(cloth.vertexCount());
  cloth.vertices.insert(cloth.vertices.end(),
                        {-size, floor, -size, size, floor, -size, 0, floor, size});
  cloth.triangles.insert(cloth.triangles.end(), {first, first + 1, first + 2});
  compareRules("with a huge floor triangle", selfScene(std::move(cloth)), {16, 64});
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main() {
  namespace dcm = deformable_contact_monitor;
  return dcm::runBenchmark("papers_rule", dcm::run);
}
