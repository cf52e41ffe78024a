// Cycles that end early: at a deadline, or when they are told to stop.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "cgal_oracle.h"
#include "core/common/cycle_limit.h"
#include "core/steady_time.h"
#include "detector_suite.h"
#include "late_work.h"
#include "pair_verdict.h"
#include "random_scenes.h"
#include "reference/reference_detectors.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// A time that the clock cannot count is as good as none, and not one that is long past.
TEST(SteadyTimes, AnEndlessTimeNeverPasses) {
  for (const double s : {1e10, 1e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_GT(Clock::now() + fromSeconds(s), Clock::now()) << s;
    EXPECT_LT(Clock::now() - fromSeconds(s), Clock::now()) << s;
    EXPECT_LT(Clock::now() + fromSeconds(-s), Clock::now()) << s;
  }
  EXPECT_LT(Clock::now() + fromSeconds(std::nan("")), Clock::now());
  EXPECT_EQ(fromSeconds(1.5), milliseconds(1500));
}

Options withDeadline(Clock::duration from_now) {
  Options options;
  options.limits.deadline = Clock::now() + from_now;
  return options;
}

// Triangles with random corners in a box: of 10 000, 13 million pairs are contacts.
TriangleMesh crossingTriangles(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<Triangle> triangles(static_cast<std::size_t>(count));
  for (Triangle& t : triangles) {
    for (Vec3f& v : t.v) v = {unit(random), unit(random), unit(random)};
  }
  return meshOf(triangles);
}

Triangle triangleOf(const Scene& scene, BodyId body, std::uint32_t triangle) {
  const TriangleMesh& mesh = scene.body(body).mesh;
  const std::uint32_t* corner = &mesh.triangles[3 * std::size_t{triangle}];
  return {{mesh.vertex(corner[0]), mesh.vertex(corner[1]), mesh.vertex(corner[2])}};
}

// All by the predicates, and some by the oracle too. Bodies without a pose.
void expectContacts(const Scene& scene, const std::vector<TrianglePair>& pairs) {
  EXPECT_TRUE(isOrdered(pairs));
  const std::size_t step = pairs.size() / 300 + 1;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const TrianglePair& p = pairs[i];
    const Triangle a = triangleOf(scene, p.body_a, p.triangle_a);
    const Triangle b = triangleOf(scene, p.body_b, p.triangle_b);
    PredicateState state{Predicates::kExact};
    ASSERT_TRUE(
        pairVerdict(a, b, p.body_a == p.body_b, AdjacentPairs::kBeyondShared, 0, state).contact)
        << p;
    if (i % step != 0) continue;
    const Scene two =
        p.body_a == p.body_b ? selfScene(meshOf({a, b})) : pairScene(meshOf({a}), meshOf({b}));
    ASSERT_EQ(1U, oracleContacts(two, AdjacentPairs::kBeyondShared).size()) << p;
  }
}

void expectCutOff(const DetectionResult& result, const std::string& because) {
  EXPECT_TRUE(result.cut_off);
  EXPECT_EQ(because, result.cut_off_because);
}

class LimitsTest : public DetectorSuite {
 protected:
  const DetectionResult& timed(const Scene& scene, const Options& options) {
    return detectLate(*detector_, scene, options, &late_ms_);
  }

  double late_ms_ = 0;
};

TEST_P(LimitsTest, ADenseMeshEndsAtItsDeadlineWithWhatWasFound) {
  const Scene scene = selfScene(crossingTriangles(22000));
  for (int cycle = 0; cycle < 3; ++cycle) {  // cold and warm
    const DetectionResult& result = timed(scene, withDeadline(milliseconds(50)));
    EXPECT_TRUE(isLittle(late_ms_));
    expectCutOff(result, "no time");
    EXPECT_TRUE(result.guaranteed) << "that is a matter of the settings";
    expectContacts(scene, result.contacts);
  }
}

TEST_P(LimitsTest, AStopFromAnotherThreadEndsIt) {
  const Scene scene = selfScene(crossingTriangles(22000));
  std::atomic<bool> stop{false};
  Options options;
  options.limits.stop = &stop;
  double stopped = 0;
  std::thread stopper([&] {
    std::this_thread::sleep_for(milliseconds(50));
    stopped = timeOnMs(detector_->backend());
    stop = true;
  });
  const DetectionResult& result = detector_->detect(scene, options);
  const double ended = timeOnMs(detector_->backend());
  stopper.join();
  EXPECT_TRUE(isLittle(ended - stopped));
  expectCutOff(result, "stopped");
  expectContacts(scene, result.contacts);
  // It is still set: the next one does not even begin.
  expectCutOff(timed(scene, options), "stopped");
  EXPECT_TRUE(isLittle(late_ms_));
}

TEST_P(LimitsTest, ALimitThatIsNotReachedChangesNothing) {
  const std::atomic<bool> stop{false};
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    const Scene scene = largeRandomScene(seed);
    const DetectionResult without = GetParam().make()->detect(scene, Options());
    EXPECT_FALSE(without.cut_off);
    EXPECT_EQ("", without.cut_off_because);
    Options options = withDeadline(std::chrono::hours(1));
    options.limits.stop = &stop;
    for (int cycle = 0; cycle < 2; ++cycle) {
      const DetectionResult& with = detector_->detect(scene, options);
      EXPECT_FALSE(with.cut_off);
      EXPECT_EQ("", with.cut_off_because);
      EXPECT_EQ(0U, with.left_out);
      EXPECT_TRUE(samePairs(without.contacts, with.contacts));
    }
  }
}

TEST_P(LimitsTest, ADeadlineInThePastIsNoTrouble) {
  for (std::uint32_t seed = 0; seed < 100; ++seed) {
    const Scene scene = randomScene(seed);
    const std::vector<TrianglePair> all = contacts(scene);
    const DetectionResult& result = timed(scene, withDeadline(-milliseconds(1)));
    EXPECT_TRUE(isLittle(late_ms_));
    expectCutOff(result, "no time");
    EXPECT_TRUE(isOrdered(result.contacts));
    EXPECT_TRUE(
        std::includes(all.begin(), all.end(), result.contacts.begin(), result.contacts.end()));
    EXPECT_EQ(scene.triangleCount(), result.counters.triangles);
    EXPECT_TRUE(samePairs(all, contacts(scene)));
  }
}

INSTANTIATE_TEST_SUITE_P(, LimitsTest, ::testing::ValuesIn(allBackends()), backendName);

class ProductLimitsTest : public LimitsTest {};

// Deadlines all over a cycle of some milliseconds, cold and warm, on a moving scene.
TEST_P(ProductLimitsTest, WhereverACycleWasCutOffTheNextIsExact) {
  Scene scene = pairScene(clothGrid(24, 1, 0, 0.1F), clothGrid(20, 1.1F, 0.013F, -0.1F));
  scene.setPairEnabled(0, 0, true);
  scene.setMargin(1, 0.001F);
  int cut_off = 0;
  for (int i = 0; i < 60; ++i) {
    RigidTransform pose;
    pose.translation[2] = 0.001 * i;
    scene.setPose(1, pose);
    const std::vector<TrianglePair> all = makeCpuDetector()->detect(scene, Options()).contacts;
    ASSERT_GT(all.size(), 100U);
    if (i % 7 == 0) detector_->reset();
    const DetectionResult& early =
        detector_->detect(scene, withDeadline(std::chrono::microseconds(50 * (i % 40))));
    cut_off += early.cut_off ? 1 : 0;
    EXPECT_TRUE(isOrdered(early.contacts));
    EXPECT_EQ(early.contacts.size(), early.separations_m.size());
    EXPECT_TRUE(
        std::includes(all.begin(), all.end(), early.contacts.begin(), early.contacts.end()));
    if (!early.cut_off) {
      EXPECT_EQ(all.size(), early.contacts.size());
    }
    const DetectionResult& next = detector_->detect(scene, Options());
    EXPECT_FALSE(next.cut_off);
    EXPECT_TRUE(samePairs(all, next.contacts));
  }
  EXPECT_GT(cut_off, 0);
}

// Millions of contacts: what is sorted and listed after the deadline is a small part of them.
TEST_P(ProductLimitsTest, ManyContactsAreNotSortedLate) {
  const Scene scene = selfScene(crossingTriangles(22000));
  for (const int ms : {300, 2000}) {
    const DetectionResult& result = timed(scene, withDeadline(milliseconds(ms)));
    EXPECT_TRUE(isLittle(late_ms_)) << ms;
    if (!result.cut_off) continue;  // a fast device
    EXPECT_TRUE(isOrdered(result.contacts));
    EXPECT_TRUE(ms < 1000 || !result.contacts.empty());
    if (result.left_out > 0) {
      EXPECT_GE(result.contacts.size(), kMostListedLate);
    }
    // CUDA may have been in the middle of its list.
    EXPECT_TRUE(detector_->backend() != "cpu" || result.contacts.size() <= kMostListedLate);
  }
}

// Two million triangles, a cycle of seconds on the CPU; each of its stages meets some deadline.
TEST_P(ProductLimitsTest, EveryStageLooksAtTheDeadline) {
  const Scene scene = selfScene(clothGrid(1000, 1, 0, 0));
  for (const int ms : {1, 30, 100, 200, 300, 400, 600, 800, 1000, 1300, 1600, 2000}) {
    Options options = withDeadline(milliseconds(ms));
    options.threads = 1;
    const DetectionResult& result = timed(scene, options);
    EXPECT_TRUE(isLittle(late_ms_)) << ms;
    EXPECT_EQ(0U, result.contacts.size());
  }
}

// One cluster of everything: sort and sweep have nobody to share with.
TEST_P(ProductLimitsTest, SoDoTheStagesWithinOneCluster) {
  const Scene scene = selfScene(clothGrid(700, 1, 0, 0));
  for (const int ms : {1, 100, 200, 300, 400, 500, 700, 900}) {
    Options options = withDeadline(milliseconds(ms));
    options.clusters = 1;
    const DetectionResult& result = timed(scene, options);
    EXPECT_TRUE(isLittle(late_ms_)) << ms;
    EXPECT_EQ(0U, result.contacts.size());
  }
}

// Triangles as large as the scene, among small ones: most pairs are those of oversized ones.
TEST_P(ProductLimitsTest, SoDoesTheStageOversized) {
  TriangleMesh mesh = clothGrid(300, 1, 0.3F, 0.2F);
  const TriangleMesh large = crossingTriangles(2500);
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  mesh.vertices.insert(mesh.vertices.end(), large.vertices.begin(), large.vertices.end());
  for (const std::uint32_t corner : large.triangles) mesh.triangles.push_back(first + corner);
  const Scene scene = selfScene(mesh);
  for (const int ms : {100, 200, 400}) {
    const DetectionResult& result = timed(scene, withDeadline(milliseconds(ms)));
    EXPECT_TRUE(isLittle(late_ms_)) << ms;
    if (!result.cut_off) continue;  // a fast device
    expectContacts(scene, result.contacts);
  }
}

INSTANTIATE_TEST_SUITE_P(, ProductLimitsTest, ::testing::ValuesIn(productBackends()), backendName);

#ifdef DCM_HAVE_FCL

TEST(FclLimits, ADenseMeshEndsAtItsDeadline) {
  const Scene scene = selfScene(crossingTriangles(2000));
  const auto detector = makeFclDetector();
  double late_ms = 0;
  expectCutOff(detectLate(*detector, scene, withDeadline(milliseconds(50)), &late_ms), "no time");
  EXPECT_TRUE(isLittle(late_ms));
  expectCutOff(detector->detect(scene, withDeadline(-milliseconds(50))), "no time");
  EXPECT_FALSE(detector->detect(selfScene(crossingTriangles(20)), Options()).cut_off);
}

#endif

}  // namespace
}  // namespace deformable_contact_monitor
