// Shows what fuzzy c-means is good for: with its prototypes the sweeps visit fewer pairs than with
// random or frozen ones. The contacts are the same with any prototypes.
#include <gtest/gtest.h>

#include <random>

#include "core/cpu/fuzzy_clustering.h"
#include "core/cpu/sweep.h"
#include "core/mesh_file.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kClusters = 256;

// One mesh against itself, ready to be swept with any prototypes.
class Frame {
 public:
  explicit Frame(const std::string& file) {
    scene_.addBody(file, readMeshFile(testDataFile(file)));
    scene_.setPairEnabled(0, 0, true);
    Counters counters;
    builder_.build(scene_, Options(), set_, counters);
    splitBySize(set_, split_);
  }

  Vec3f centroid(TriangleIndex triangle) const {
    const Triangle t = set_.posed(triangle);
    const Vec3f scaled[3] = {split_.scale.apply(t.v[0]), split_.scale.apply(t.v[1]),
                             split_.scale.apply(t.v[2])};
    return centroidOf(scaled);
  }

  std::vector<Vec3f> sample() const {
    std::vector<Vec3f> points;
    const auto count = static_cast<std::uint32_t>(set_.size());
    for (std::uint32_t t = 0; t < count; t += count / 4096) {
      points.push_back(centroid(TriangleIndex(t)));
    }
    return points;
  }

  // In this frame's scaled coordinates, of those of another.
  std::vector<Vec3f> converted(const std::vector<Vec3f>& prototypes, const Frame& from) const {
    std::vector<Vec3f> here;
    for (const Vec3f& p : prototypes) {
      here.push_back(toFloat(split_.scale.applyExact(from.split_.scale.invert(p))));
    }
    return here;
  }

  std::vector<Vec3f> randomPrototypes(unsigned seed) const {
    std::mt19937 random(seed);
    std::vector<Vec3f> prototypes(kClusters);
    for (Vec3f& p : prototypes)
      p = centroid(TriangleIndex(static_cast<std::uint32_t>(random() % set_.size())));
    return prototypes;
  }

  CycleOutput<Triangle> sweep(const std::vector<Vec3f>& points) const {
    Prototypes prototypes;
    prototypes.build(points);
    ClusterAssignment<Triangle> assignment;
    std::vector<NearestPrototype> nearest;
    ClusterAssigner().assign(scene_, set_, split_, prototypes, Options(), nearest, assignment);
    const BodyGroups groups(scene_);
    const std::vector<float> slack = scaledSlacks(scene_, Options(), split_.scale);
    const Options options;
    const CycleInput<Triangle> input{scene_, set_, split_, assignment, groups, slack, options};
    SweepBuffers<Triangle> buffers;
    CycleOutput<Triangle> output(input);
    ClusterSweeper<Triangle> sweeper(input, buffers, output);
    for (std::uint32_t g = 0; g < assignment.clusterCount(); ++g) sweeper.sweep(ClusterIndex(g));
    return output;
  }

 private:
  Scene scene_;
  WorkingSetBuilder builder_;
  WorkingSet set_;
  SizeSplit split_;
};

std::vector<Vec3f> clustered(const Frame& frame, int iterations) {
  FuzzyClustering clustering(Options().fuzzifier);
  const std::vector<Vec3f> sample = frame.sample();
  clustering.initialise(sample, kClusters);
  for (int i = 0; i < iterations; ++i) clustering.iterate(sample);
  return clustering.prototypes();
}

TEST(PrototypeQuality, BetterThanRandomOnes) {
  DCM_REQUIRE_TEST_DATA();
  const Frame frame("cloth-ball/cloth_ball92.ply");
  const CycleOutput<Triangle> fuzzy = frame.sweep(clustered(frame, 5));
  for (const unsigned seed : {1U, 2U, 3U}) {
    const CycleOutput<Triangle> random = frame.sweep(frame.randomPrototypes(seed));
    EXPECT_LT(fuzzy.counters.interval_overlaps, random.counters.interval_overlaps)
        << "seed " << seed;
    EXPECT_EQ(fuzzy.contacts.size(), random.contacts.size());
  }
}

TEST(PrototypeQuality, FollowingTheSceneBeatsFrozenOnes) {
  DCM_REQUIRE_TEST_DATA();
  const Frame before("cloth-ball/cloth_ball93.ply"), now("cloth-ball/cloth_ball92.ply");
  // Frozen where they started, and frozen where the scene was a frame ago.
  const std::vector<Vec3f> started = clustered(now, 0);
  const std::vector<Vec3f> old = now.converted(clustered(before, 5), before);
  FuzzyClustering following(Options().fuzzifier);
  following.setPrototypes(old);
  for (int i = 0; i < 5; ++i) following.iterate(now.sample());
  const std::uint64_t followed = now.sweep(following.prototypes()).counters.interval_overlaps;
  EXPECT_LT(followed, now.sweep(started).counters.interval_overlaps);
  EXPECT_LT(followed, now.sweep(old).counters.interval_overlaps);
}

}  // namespace
}  // namespace deformable_contact_monitor
