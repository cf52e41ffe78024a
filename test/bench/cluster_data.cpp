// Writes how the CPU backend divides a cloth into clusters and sorts them, for draw_pictures.py.
//
//   prototype CLUSTER X Y Z                          [m]
//   axis CLUSTER X Y Z                               first principal axis, of length 1
//   triangle CLUSTER CLUSTERS X Y Z ... LOW HIGH     nine coordinates [m]; its interval along that
//                                                    axis, scaled. Lines are in the sorted order.
// CLUSTERS is the number of clusters that a triangle is in; it has a line in each of them.
#include <cstdio>

#include "core/cpu/cluster.h"
#include "core/cpu/sort.h"
#include "core/mesh_file.h"
#include "core/rules/principal_axes.h"
#include "run_benchmark.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

void print(const Vec3d& v) { std::printf(" %.6g %.6g %.6g", v.x, v.y, v.z); }

// The axes that `sort` makes for the cluster.
PrincipalAxes axesOf(const CycleInput<Triangle>& input, const SortedCluster<Triangle>& sorted) {
  Moments moments;
  Vec3f first;
  for (std::size_t i = 0; i < sorted.triangles.size(); ++i) {
    Vec3f scaled[3];
    input.split.scaled(input.set.posed<Triangle>(sorted.triangles[i].triangle), scaled);
    const Vec3f centroid = meanOf<Triangle>(scaled);
    if (i == 0) first = centroid;
    moments.add(centroid - first);
  }
  return principalAxes(covarianceOf(moments));
}

void printCluster(const CycleInput<Triangle>& input, const std::vector<std::uint32_t>& clusters_of,
                  ClusterIndex g, ClusterSorter<Triangle>& sorter) {
  SortedCluster<Triangle> sorted;
  sorter.sort(g, sorted);
  std::printf("axis %u", g.value);
  print(toDouble(axesOf(input, sorted).axis[0]));
  for (std::size_t i = 0; i < sorted.triangles.size(); ++i) {
    const TriangleIndex t = sorted.triangles[i].triangle;
    std::printf("\ntriangle %u %u", g.value, clusters_of[t.value]);
    for (const Vec3f& corner : input.set.posed<Triangle>(t).v) print(toDouble(corner));
    std::printf(" %.6g %.6g", sorted.lo[i], sorted.hi[i]);
  }
  std::printf("\n");
}

int run() {
  Options options;
  options.clusters = 16;
  const Scene scene = selfScene(readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply")));
  WorkingSet set;
  Counters counters;
  WorkingSetBuilder().build(scene, options, set, counters);
  SizeSplit split;
  splitBySize(set, split);
  Prototypes prototypes;
  PrototypeTracker().update<Triangle>(set, split, options, noLimit(), prototypes);
  ClusterAssignment<Triangle> assignment;
  ClusterAssigner().assign(scene, set, split, prototypes, options, assignment);

  const BodyGroups groups(scene);
  const std::vector<float> slack = scaledSlacks(scene, options, split.scale);
  const CycleInput<Triangle> input{scene, set, split, assignment, groups, slack, options};
  std::vector<std::uint32_t> clusters_of(set.size());
  for (const ClusterEntry<Triangle>& entry : assignment.entries) {
    clusters_of[entry.triangle.value] = entry.list_size;
  }
  SortBuffers<Triangle> buffers;
  ClusterSorter<Triangle> sorter(input, buffers);
  for (std::uint32_t g = 0; g < assignment.clusterCount(); ++g) {
    std::printf("prototype %u", g);
    print(split.scale.invert(prototypes.view().prototypes[g]));
    std::printf("\n");
    printCluster(input, clusters_of, ClusterIndex(g), sorter);
  }
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main() {
  namespace dcm = deformable_contact_monitor;
  return dcm::runBenchmark("cluster_data", dcm::run);
}
