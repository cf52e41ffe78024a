// Swept cycles that end early, or with little memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "core/predicates/swept_exact.h"
#include "late_work.h"
#include "moving_meshes.h"
#include "scenes.h"
#include "swept_suite.h"

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

Options withDeadline(Clock::duration from_now) {
  Options options = sweptOptions();
  options.first_times = true;
  options.limits.deadline = Clock::now() + from_now;
  return options;
}

// Triangles with random corners in a box, which move to other ones.
Scene crossingTriangles(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<Triangle> triangles(static_cast<std::size_t>(count));
  for (Triangle& t : triangles) {
    for (Vec3f& v : t.v) v = {unit(random), unit(random), unit(random)};
  }
  Scene scene = selfScene(meshOf(triangles));
  scene.setEarlier(0, RigidTransform(), shaken(scene.body(0).mesh, 0.5F, 8));
  return scene;
}

void expectContacts(const Scene& scene, const DetectionResult& result) {
  EXPECT_TRUE(isOrdered(result.contacts));
  EXPECT_EQ(result.contacts.size(), result.first_times.size());
  TriangleMesh before = scene.body(0).mesh;
  before.vertices = scene.body(0).earlier->vertices;
  const std::vector<MovingTriangle> triangles = movingTriangles(before, scene.body(0).mesh);
  const std::size_t step = result.contacts.size() / 20000 + 1;
  for (std::size_t i = 0; i < result.contacts.size(); i += step) {
    const TrianglePair& p = result.contacts[i];
    const MovingTriangle &a = triangles[p.triangle_a], &b = triangles[p.triangle_b];
    PredicateState state;
    ASSERT_EQ(PartVerdict::kMeet, sweptVerdict(a, b, sharedTrajectories(a, b),
                                               AdjacentPairs::kBeyondShared, false, state)
                                      .part)
        << p;
  }
}

class SweptLimits : public DetectorSuite {
 protected:
  const DetectionResult& timed(const Scene& scene, const Options& options) {
    return detectLate(*detector_, scene, options, &late_ms_);
  }

  double late_ms_ = 0;
};

TEST_P(SweptLimits, ADenseMeshEndsAtItsDeadlineWithWhatWasFound) {
  const Scene scene = crossingTriangles(10000);
  for (const int ms : {50, 150, 400}) {
    const DetectionResult& result = timed(scene, withDeadline(milliseconds(ms)));
    EXPECT_TRUE(isLittle(late_ms_));
    EXPECT_TRUE(result.isOutOfTime());
    EXPECT_TRUE(result.guaranteed) << "that is a matter of the settings";
    expectContacts(scene, result);
  }
}

INSTANTIATE_TEST_SUITE_P(, SweptLimits, ::testing::ValuesIn(sweptBackends()), backendName);

class SweptProductLimits : public SweptLimits {};

TEST_P(SweptProductLimits, EveryStageLooksAtTheDeadline) {
  Scene scene = selfScene(clothGrid(400, 1, 0, 0));
  scene.setEarlier(0, translationBy(0, 0, 1), shaken(scene.body(0).mesh, 0.0001F, 2));
  for (const int ms : {1, 20, 40, 60, 80, 100, 150, 200, 250, 300, 400, 600}) {
    Options options = withDeadline(milliseconds(ms));
    options.threads = 1;
    timed(scene, options);
    EXPECT_TRUE(isLittle(late_ms_)) << ms;
  }
}

// Two sheets that slide in one plane: no filter tells anything of what comes to meet there.
TEST_P(SweptProductLimits, SoDoVerdictsThatAreAllExact) {
  Scene scene = pairScene(clothGrid(40, 1, 0, 0), clothGrid(37, 1, 0, 0));
  scene.setEarlier(1, translationBy(0.9, 0.3, 0), shaken(scene.body(1).mesh, 0, 1));
  // A busy machine comes to a verdict only with a later deadline. All of them take many seconds.
  std::uint64_t exact = 0;
  for (int ms = 20; exact == 0; ms *= 2) {
    Options options = withDeadline(milliseconds(ms));
    options.clusters = options.threads = 1;
    const DetectionResult& result = timed(scene, options);
    EXPECT_TRUE(isLittle(late_ms_)) << ms;
    ASSERT_TRUE(result.isOutOfTime());
    exact = result.counters.exact;
  }
}

TEST_P(SweptProductLimits, WhereverACycleWasCutOffTheNextIsExact) {
  Scene scene = pairScene(clothGrid(24, 1, 0, 0.1F), clothGrid(20, 1.1F, 0.013F, -0.1F));
  scene.setPairEnabled(0, 0, true);
  int cut_off = 0;
  for (unsigned i = 0; i < 40; ++i) {
    scene.setEarlier(1, translationBy(0, 0, 0.001 * i), shaken(scene.body(1).mesh, 0.01F, i));
    const std::vector<TrianglePair> all = makeCpuDetector()->detect(scene, sweptOptions()).contacts;
    ASSERT_GT(all.size(), 100U);
    if (i % 7 == 0) detector_->reset();
    const DetectionResult& early =
        detector_->detect(scene, withDeadline(std::chrono::microseconds(150 * (i % 40))));
    cut_off += early.cut_off ? 1 : 0;
    EXPECT_TRUE(isOrdered(early.contacts));
    EXPECT_EQ(early.contacts.size(), early.first_times.size());
    EXPECT_TRUE(
        std::includes(all.begin(), all.end(), early.contacts.begin(), early.contacts.end()));
    EXPECT_TRUE(samePairs(all, contacts(scene, sweptOptions())));
  }
  EXPECT_GT(cut_off, 0);
}

INSTANTIATE_TEST_SUITE_P(, SweptProductLimits, ::testing::ValuesIn(sweptProductBackends()),
                         backendName);

TEST(SweptMemory, WithLittleOfItTheCountStaysExactAndTheListIsPartOfIt) {
  Scene scene = pairScene(clothGrid(100, 1, 0, 0.1F), clothGrid(101, 1, 0.001F, -0.1F));
  scene.setEarlier(1, translationBy(0, 0, 0.01));
  Options options = sweptOptions();
  options.first_times = true;
  for (const float pad_m : {0.0F, 0.001F}) {
    scene.setPad(1, pad_m);
    const auto all = makeCpuDetector()->detect(scene, options).contacts;
    ASSERT_GT(all.size(), 2500U);
    for (const std::uint64_t bytes : {1U, 60000U, 120000U}) {
      options.threads = 2;
      const auto detector = makeCpuDetector({bytes});
      const DetectionResult& result = detector->detect(scene, options);
      EXPECT_EQ(all.size(), result.contacts.size() + result.left_out);
      EXPECT_GT(result.left_out, 0U);
      EXPECT_FALSE(result.cut_off) << "all were found";
      EXPECT_TRUE(isOrdered(result.contacts));
      EXPECT_EQ(result.contacts.size(), result.first_times.size());
      EXPECT_EQ(pad_m > 0 ? result.contacts.size() : 0, result.within_pad.size());
      EXPECT_TRUE(
          std::includes(all.begin(), all.end(), result.contacts.begin(), result.contacts.end()));
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
