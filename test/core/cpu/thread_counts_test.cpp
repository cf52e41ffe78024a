// The CPU backend's results do not depend on how many threads it has, nor on what ran before.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/common/parallel.h"
#include "core/common/vertex_identity.h"
#include "core/cpu/output.h"
#include "core/cpu_detector.h"
#include "random_scenes.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kMostThreads = 7;

// More threads than this machine has cores.
class ThreadCounts : public testing::Test {
 private:
  tbb::global_control control_{tbb::global_control::max_allowed_parallelism, kMostThreads};
};

std::vector<std::uint64_t> valuesOf(const Counters& c) {
  return {
      c.triangles, c.rejected,        c.posed, c.culled,          c.clustered,         c.large,
      c.clusters,  c.cluster_entries, c.exact, c.largest_cluster, c.interval_overlaps, c.candidates,
      c.undecided};
}

template <class T>
bool sameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool sameGeometry(const PairGeometry& a, const PairGeometry& b) {
  return a.point_a == b.point_a && a.point_b == b.point_b && a.normal == b.normal &&
         a.separation_m == b.separation_m && a.flags == b.flags;
}

void expectSame(const DetectionResult& one, const DetectionResult& other) {
  EXPECT_EQ(one.contacts, other.contacts);
  EXPECT_TRUE(sameBits(one.separations_m, other.separations_m));
  EXPECT_TRUE(sameBits(one.within_pad, other.within_pad));
  EXPECT_TRUE(sameBits(one.first_times, other.first_times));
  EXPECT_TRUE(std::equal(one.geometry.begin(), one.geometry.end(), other.geometry.begin(),
                         other.geometry.end(), sameGeometry));
  EXPECT_EQ(valuesOf(one.counters), valuesOf(other.counters));
  EXPECT_EQ(one.left_out, other.left_out);
}

// Three cycles, by 1, 2, 3 and 7 threads. How many contacts there are.
std::size_t expectSameByAll(Scene& scene, Options options) {
  const auto by_one = makeCpuDetector();
  std::map<int, std::unique_ptr<Detector>> others;
  for (const int threads : {2, 3, kMostThreads}) others[threads] = makeCpuDetector();
  std::size_t contacts = 0;
  for (int cycle = 0; cycle < 3; ++cycle) {
    options.threads = 1;
    const DetectionResult& one = by_one->detect(scene, options);
    for (const auto& [threads, detector] : others) {
      SCOPED_TRACE(std::to_string(threads) + " threads, cycle " + std::to_string(cycle));
      options.threads = threads;
      expectSame(one, detector->detect(scene, options));
    }
    contacts += one.contacts.size();
    std::vector<float> vertices = scene.body(0).mesh.vertices;
    for (float& x : vertices) x *= 1.01F;
    scene.setVertices(0, vertices.data(), vertices.size() / 3);
  }
  return contacts;
}

// Two cloths of some blocks of triangles and vertices each, crumpled; many vertices repeat.
Scene crumpledCloths(bool soup) {
  TriangleMesh a = clothGrid(70, 1, 0, 0.1F), b = clothGrid(71, 1, 0.01F, -0.1F);
  for (std::size_t i = 0; i < a.vertices.size(); i += 3) {
    a.vertices[i] = std::abs(a.vertices[i] - 0.507F);
  }
  Scene scene = pairScene(soup ? soupOf(a) : a, b);
  scene.setPairEnabled(0, 0, true);
  return scene;
}

TEST_F(ThreadCounts, OfCloths) {
  for (const bool soup : {false, true}) {
    for (const AdjacentPairs adjacent : {AdjacentPairs::kSkip, AdjacentPairs::kBeyondShared}) {
      Scene scene = crumpledCloths(soup);
      Options options;
      options.adjacent = adjacent;
      EXPECT_GT(expectSameByAll(scene, options), 3000U);
    }
  }
}

TEST_F(ThreadCounts, WithMarginsAndGeometry) {
  Scene scene = crumpledCloths(false);
  scene.setMargin(0, 0.002F);
  Options options;
  options.geometry = true;
  EXPECT_GT(expectSameByAll(scene, options), 3000U);
}

TEST_F(ThreadCounts, OfSteps) {
  Scene scene = crumpledCloths(false);
  std::vector<float> earlier = scene.body(0).mesh.vertices;
  for (std::size_t i = 2; i < earlier.size(); i += 3) earlier[i] += 0.01F;
  scene.setEarlier(0, RigidTransform(), earlier);
  Options options;
  options.motion = Motion::kSwept;
  options.first_times = true;
  EXPECT_GT(expectSameByAll(scene, options), 3000U);
}

TEST_F(ThreadCounts, OfRandomScenes) {
  std::size_t contacts = 0;
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene = seed % 20 == 0 ? largeRandomScene(seed) : randomScene(seed);
    contacts += expectSameByAll(scene, Options());
  }
  EXPECT_GT(contacts, 1000U);
}

TEST_F(ThreadCounts, TheLeastOfEqualVerticesIsTold) {
  std::mt19937 random(1);
  std::vector<float> xyz(3 * 30000);
  for (float& x : xyz) x = static_cast<float>(random() % 25);
  std::map<std::tuple<float, float, float>, std::uint32_t> first;
  VertexIdentity identity;
  for (int repeat = 0; repeat < 5; ++repeat) {
    first.clear();
    std::vector<std::uint32_t> least_equal;
    identity.identify(xyz, least_equal);
    for (std::uint32_t i = 0; i < least_equal.size(); ++i) {
      const auto found = first.insert({{xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]}, i}).first;
      ASSERT_EQ(found->second, least_equal[i]) << i;
    }
    std::shuffle(xyz.begin(), xyz.end(), random);
  }
}

// Lists of any lengths, of few triangles and of many.
TEST_F(ThreadCounts, ContactsAreWrittenInOrder) {
  std::mt19937 random(2);
  ContactWriter<Triangle> writer;
  Scene scene = pairScene(clothGrid(1, 1, 0, 0), clothGrid(1, 1, 0, 0));
  scene.setMargin(0, 1);
  for (const std::uint32_t triangles : {2U, 700U, 5000U, 6000000U}) {
    WorkingSet set;
    set.body.assign(triangles, 0);
    for (std::uint32_t t = 0; t < triangles; ++t) set.triangle.push_back(2 * t);
    for (const std::size_t count : {0U, 1U, 1500U, 40000U}) {
      std::vector<TrianglePair> expected;
      ContactList<Triangle> contacts;
      for (std::size_t i = 0; i < count; ++i) {
        const auto a = static_cast<std::uint32_t>(random() % triangles);
        const auto b = static_cast<std::uint32_t>(random() % triangles);
        ContactList<Triangle> one;
        (i % 7 == 0 ? one : contacts).add({TriangleIndex(a), TriangleIndex(b), 0.5F * b});
        contacts.take(one);
        expected.push_back({0, 2 * a, 0, 2 * b});
      }
      std::sort(expected.begin(), expected.end());
      DetectionResult result;
      writer.write(scene, Options(), set, contacts, noLimit(), result);
      ASSERT_EQ(expected, result.contacts);
      ASSERT_EQ(count, result.separations_m.size());
      for (std::size_t i = 0; i < count; ++i) {
        ASSERT_EQ(result.separations_m[i], 0.25F * result.contacts[i].triangle_b);
      }
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
