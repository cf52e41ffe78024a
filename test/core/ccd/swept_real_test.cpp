// Real steps: times and a sample of the pairs by the oracle, both ends, backwards, as a soup.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>

#include "cgal_oracle.h"
#include "core/mesh_file.h"
#include "moving_meshes.h"
#include "scenes.h"
#include "swept_expected.h"

namespace deformable_contact_monitor {
namespace {

struct RealStep {
  const char* name;
  const char *from, *to;
  std::size_t skip, in_neither_state;  // contacts with itself, and those of them in neither state
};

constexpr RealStep kSteps[] = {
    {"cloth_ball", "cloth-ball/cloth_ball92.ply", "cloth-ball/cloth_ball93.ply", 204491, 63233},
    {"funnel", "cloth-funnel/227.ply", "cloth-funnel/228.ply", 381, 40},
};

std::ostream& operator<<(std::ostream& out, const RealStep& step) { return out << step.name; }

class SweptReal : public ::testing::TestWithParam<std::tuple<Backend, RealStep>> {
 protected:
  void SetUp() override {
    DCM_REQUIRE_TEST_DATA();
    const RealStep& step = std::get<1>(GetParam());
    from_ = readMeshFile(testDataFile(step.from));
    to_ = readMeshFile(testDataFile(step.to));
    scene_ = stepScene(selfScene(from_), selfScene(to_));
    detector_ = std::get<0>(GetParam()).make();
  }

  std::vector<TrianglePair> found(const Options& options, const Scene& scene) {
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_TRUE(result.guaranteed);
    EXPECT_TRUE(result.without_step.empty());
    EXPECT_EQ(result.counters.rejected, 0U);
    return result.contacts;
  }

  TriangleMesh from_, to_;
  Scene scene_;
  std::unique_ptr<Detector> detector_;
};

// The oracle on a sample of the contacts and of the pairs of boxes; its static part on each end,
// whose contacts are all found; and without motion it is the static result.
TEST_P(SweptReal, AgreesWithTheOracle) {
  const RealStep& step = std::get<1>(GetParam());
  const DetectionResult result = detector_->detect(scene_, timedOptions(AdjacentPairs::kSkip));
  ASSERT_EQ(result.contacts.size(), step.skip);
  std::vector<TrianglePair> of_ends;
  for (const TriangleMesh* mesh : {&from_, &to_}) {
    const std::vector<TrianglePair> still = oracleContacts(selfScene(*mesh), AdjacentPairs::kSkip);
    ASSERT_TRUE(includes(result.contacts, still));
    const Scene standing = stepScene(selfScene(*mesh), selfScene(*mesh));
    ASSERT_TRUE(samePairs(still, found(sweptOptions(AdjacentPairs::kSkip), standing)));
    std::vector<TrianglePair> both;
    std::set_union(of_ends.begin(), of_ends.end(), still.begin(), still.end(),
                   std::back_inserter(both));
    of_ends = both;
  }
  EXPECT_EQ(result.contacts.size() - of_ends.size(), step.in_neither_state);
  const std::vector<MovingTriangle> triangles = movingTriangles(from_, to_);
  std::mt19937 random(1);
  std::size_t times = 0;
  for (int i = 0; i < 250; ++i) {  // contacts, with their times
    const std::size_t place = random() % result.contacts.size();
    const TrianglePair& p = result.contacts[place];
    const MovingTriangle &a = triangles[p.triangle_a], &b = triangles[p.triangle_b];
    const auto time = firstSweptContact(a.from, a.to, b.from, b.to, AdjacentPairs::kSkip);
    ASSERT_TRUE(time) << p;
    ASSERT_TRUE(holds(result.first_times[place], *time)) << p;
    times += time->low > 0;
  }
  EXPECT_GT(times, 10U);
  const auto boxes = sweptBoxPairs(triangles);
  for (int i = 0; i < 1500; ++i) {
    const auto& [a, b] = boxes[random() % boxes.size()];
    const MovingTriangle &s = triangles[a], &t = triangles[b];
    const bool listed = std::binary_search(result.contacts.begin(), result.contacts.end(),
                                           TrianglePair{0, a, 0, b});
    ASSERT_EQ(sweptContact(s.from, s.to, t.from, t.to, AdjacentPairs::kSkip), listed)
        << a << " " << b;
  }
}

TEST_P(SweptReal, BackwardsIsTheSame) {
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    const std::vector<TrianglePair> forwards = found(sweptOptions(adjacent), scene_);
    EXPECT_TRUE(samePairs(forwards, found(sweptOptions(adjacent), reversedScene(scene_))));
  }
}

// Each triangle with vertices of its own: shared are vertices by their ways.
TEST_P(SweptReal, AsASoup) {
  const Scene soup = stepScene(selfScene(soupOf(from_)), selfScene(soupOf(to_)));
  const std::vector<TrianglePair> welded = found(sweptOptions(), scene_);
  EXPECT_TRUE(samePairs(welded, found(sweptOptions(), soup)));
}

INSTANTIATE_TEST_SUITE_P(, SweptReal,
                         ::testing::Combine(::testing::ValuesIn(sweptProductBackends()),
                                            ::testing::ValuesIn(kSteps)),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param).name) + "_" +
                                  std::get<1>(info.param).name;
                         });

}  // namespace
}  // namespace deformable_contact_monitor
