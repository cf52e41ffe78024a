// Each state equals a detection of its own, to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include "core/mesh_file.h"
#include "parts_fixture.h"
#include "random_scenes.h"
#include "scenes.h"
#include "states_fixture.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : random_(seed) {}
  std::uint32_t below(std::uint32_t n) { return random_() % n; }
  bool oneIn(std::uint32_t n) { return below(n) == 0; }
  double either() { return std::uniform_real_distribution<double>(-1, 1)(random_); }

 private:
  std::mt19937 random_;
};

RigidTransform rotation(double a, double b) {
  return {{std::cos(a), -std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::sin(a),
           std::cos(a) * std::cos(b), -std::cos(a) * std::sin(b), 0, std::sin(b), std::cos(b)},
          {0, 0, 0}};
}

// A pose that moves a body by about reach_m [m]: often the identity, along grid lines, far away, or
// no rotation at all.
RigidTransform anyPose(Dice& dice, double reach_m) {
  RigidTransform pose;
  if (dice.oneIn(8)) return pose;
  if (!dice.oneIn(4)) pose = rotation(4 * dice.either(), 4 * dice.either());
  for (double& t : pose.translation) t = reach_m * dice.either();
  if (dice.oneIn(4)) {
    for (double& t : pose.translation) t = std::round(2 * t) / 2;
  }
  if (dice.oneIn(12)) {
    for (double& r : pose.rotation) r *= std::pow(10.0, 3 * dice.either());
  }
  if (dice.oneIn(12)) {
    for (double& r : pose.rotation) r += 0.3 * dice.either();
  }
  if (dice.oneIn(24)) pose.translation[dice.below(3)] *= 1e6;
  if (dice.oneIn(40)) pose.rotation[dice.below(9)] = 0;
  if (dice.oneIn(60)) {
    for (double& r : pose.rotation) r *= 1e38;
  }
  if (dice.oneIn(80)) pose.rotation[dice.below(9)] = NAN;
  return pose;
}

States anyStates(const Scene& scene, Dice& dice, std::size_t count, double reach_m) {
  States states;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!dice.oneIn(3)) states.moved.push_back(id);
  }
  if (dice.oneIn(2)) std::reverse(states.moved.begin(), states.moved.end());
  for (std::size_t i = 0; i < count * states.moved.size(); ++i) {
    states.poses.push_back(anyPose(dice, reach_m));
  }
  return states;
}

void giveRadii(Scene& scene, Dice& dice) {
  static constexpr float kRadii[] = {0, 0.05F, 0.25F, 1, 1e-40F, 1e20F};
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (dice.oneIn(2)) scene.setRadius(id, kRadii[dice.below(6)]);
  }
}

class StatesSuite : public StatesTest {
 protected:
  void count(const std::vector<StateAnswer>& answers) {
    for (const StateAnswer& answer : answers) ++counts_[static_cast<int>(answer.decision)];
  }
  void expectAllKinds() const {
    for (const std::size_t count : counts_) EXPECT_GT(count, 50U);
  }

  std::array<std::size_t, 4> counts_{};  // by PairDecision
};

TEST_P(StatesSuite, EqualSingleDetectionsInRandomScenes) {
  const std::uint32_t seeds = numberFromEnvironment("DCM_STATE_SCENES", 1500);
  for (std::uint32_t seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE(seed);
    Dice dice(seed);
    Scene scene = randomScene(seed);
    static constexpr float kMargins[] = {0, 0.1F, 0.5F, 1, 10, 1e-42F, 1e20F, FLT_MAX};
    for (BodyId id = 0; id < scene.bodyCount(); ++id) scene.setMargin(id, kMargins[dice.below(8)]);
    if (dice.oneIn(2)) divide(scene, seed);
    if (dice.oneIn(4)) giveMargins(scene, seed);
    if (dice.oneIn(3)) giveRadii(scene, dice);
    count(expectSame(scene, anyStates(scene, dice, 4, dice.oneIn(2) ? 1 : 4)));
    if (HasFailure()) return;
  }
  expectAllKinds();
}

// Cloths and soups of several tiles, small parts of which are near each other.
TEST_P(StatesSuite, EqualSingleDetectionsOfMeshesOfManyTiles) {
  single_ = SingleDetections(makeCpuDetector());
  const std::uint32_t seeds = numberFromEnvironment("DCM_STATE_SCENES", 25);
  for (std::uint32_t seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE(seed);
    Dice dice(seed);
    Scene scene;
    for (BodyId id = 0; id < 3; ++id) {
      TriangleMesh mesh = clothGrid(3 + static_cast<int>(dice.below(14)), 1, 0, 0.1F);
      if (dice.oneIn(3)) mesh = clothGrid(3 + static_cast<int>(dice.below(9)), 1, 0, 0);
      for (float& x : mesh.vertices) {
        if (dice.oneIn(300)) x = NAN;
      }
      scene.addBody("body " + std::to_string(id), mesh);
      scene.setPose(id, rotation(dice.either(), dice.either()));
      if (dice.oneIn(2)) scene.setMargin(id, static_cast<float>(0.2 + 0.2 * dice.either()));
      for (BodyId other = 0; other <= id; ++other) scene.setPairEnabled(other, id, true);
    }
    if (dice.oneIn(3)) divide(scene, seed);
    if (dice.oneIn(4)) giveMargins(scene, seed);
    if (dice.oneIn(3)) giveRadii(scene, dice);
    for (int change = 0; change < 3; ++change) {
      count(expectSame(scene, anyStates(scene, dice, 8, 1)));
      std::vector<float> vertices = scene.body(1).mesh.vertices;
      for (float& x : vertices) x += static_cast<float>(0.05 * dice.either());
      scene.setVertices(1, vertices.data(), vertices.size() / 3);
      if (change == 1) scene.setMesh(0, clothGrid(5, 1, 0.2F, 0.1F));
    }
    if (HasFailure()) return;
  }
  for (const PairDecision decision :
       {PairDecision::kNone, PairDecision::kNear, PairDecision::kContact}) {
    EXPECT_GT(counts_[static_cast<int>(decision)], 50U);
  }
}

TEST_P(StatesSuite, TellApartTheNearestOfTies) {
  Scene scene;
  for (BodyId id = 0; id < 4; ++id) {
    scene.addBody("body " + std::to_string(id), clothGrid(9, 1, 0, 0));
    scene.setMargin(id, 1);
    for (BodyId other = 0; other < id; ++other) scene.setPairEnabled(other, id, true);
  }
  States states{{0, 1, 2, 3}, {}};
  for (const double gap : {0.0, 0.25, 1.0, std::nextafter(1.0, 2.0), 2.0}) {
    for (BodyId id = 0; id < 4; ++id) {
      RigidTransform pose;
      pose.translation[2] = gap * (id == 0 ? 2 : (id == 2 ? 0 : id));
      states.poses.push_back(pose);
    }
  }
  const auto answers = expectSame(scene, states);
  EXPECT_EQ(PairDecision::kContact, answers[0].decision);
  EXPECT_EQ(PairDecision::kNear, answers[1].decision);
  EXPECT_EQ(1U, answers[1].nearest.pair.body_b);  // as near as 1 and 2, and as 0 and 3
  EXPECT_EQ(0.25F, answers[1].nearest.distance_m);
  EXPECT_EQ(PairDecision::kNear, answers[2].decision);  // at the margin itself
  EXPECT_EQ(PairDecision::kNear, answers[3].decision);  // it rounds to that
  EXPECT_EQ(PairDecision::kNone, answers[4].decision);
}

// Gaps along an axis that are above a distance in real numbers, and round to it.
TEST_P(StatesSuite, RoundDistancesAsDetectorsDo) {
  for (const bool by_radius : {true, false}) {
    Scene scene = pairScene({{-1, 0, 0, -1e-9F, 0, 0, -1, 1, 0}, {0, 1, 2}},
                            {{0.5F, 0, 0, 2, 0, 0, 2, 1, 0}, {0, 1, 2}});
    for (const BodyId id : {0U, 1U}) {
      if (by_radius) scene.setRadius(id, 0.25F);
      if (!by_radius) scene.setMargin(id, 0.5F);
    }
    const auto answers = expectSame(scene, {{0}, {RigidTransform()}});
    EXPECT_EQ(by_radius ? PairDecision::kContact : PairDecision::kNear, answers[0].decision);
  }
}

// Poses far from the origin bring points that are far from their body's origin back to it, so that
// what is left is small beside the numbers that it was computed from.
TEST_P(StatesSuite, BoundDistancesWhereSizesCancel) {
  Dice dice(1);
  for (int round = 0; round < 300; ++round) {
    Scene scene;
    for (BodyId id = 0; id < 2; ++id) {
      TriangleMesh grains;
      for (std::uint32_t i = 0; i < 3; ++i) {
        const auto x = static_cast<float>((id == 0 ? 1000 : 0) + dice.either());
        grains.vertices.insert(grains.vertices.end(), {x, static_cast<float>(dice.either()), 0});
        grains.triangles.insert(grains.triangles.end(), {i, i, i});
      }
      scene.addBody("body " + std::to_string(id), grains);
      scene.setMargin(id, 2);
    }
    scene.setPairEnabled(0, 1, true);
    RigidTransform pose;
    pose.translation[0] = -1000 + dice.either();
    expectSame(scene, {{0}, {pose}});
    if (HasFailure()) return;
  }
}

TEST_P(StatesSuite, LookOnlyAtPairsWithAMovedBody) {
  Scene scene;
  for (BodyId id = 0; id < 3; ++id) {
    scene.addBody("body " + std::to_string(id), clothGrid(3, 1, 0, 0.1F));
    for (BodyId other = 0; other <= id; ++other) scene.setPairEnabled(other, id, true);
  }
  RigidTransform away;
  away.translation[0] = 9;
  StateOptions options;
  options.pairs = true;
  const States states{{2}, {RigidTransform(), away}};
  const StateResults& results = checker_->check(scene, states.batch(), options);
  EXPECT_EQ(PairDecision::kContact, results.states[0].decision);
  EXPECT_EQ(PairDecision::kNone, results.states[1].decision);  // 0 touches 1, and each itself
  EXPECT_EQ((std::vector<TouchingBodies>{{0, 0, 2}, {0, 1, 2}}), results.pairs);
  scene.setPairEnabled(0, 2, false);
  scene.setPartPairEnabled(1, 0, 2, 0, false);
  EXPECT_EQ(PairDecision::kNone,
            checker_->check(scene, states.batch(), options).states[0].decision);
}

TEST_P(StatesSuite, CountRejectedTriangles) {
  Scene scene = pairScene(clothGrid(4, 1, 0, 0), clothGrid(4, 1, 0.5F, 0));
  scene.addBody("other", clothGrid(1, 1, 0, 0));
  std::vector<float> vertices = scene.body(1).mesh.vertices;
  vertices[0] = NAN;
  scene.setVertices(1, vertices.data(), vertices.size() / 3);
  const States states{{0}, {RigidTransform()}};
  const auto rejected = [&] { return checker_->check(scene, states.batch(), {}).rejected; };
  ASSERT_EQ(1U, rejected().size());
  const std::uint64_t count = rejected()[0].count;
  EXPECT_EQ((RejectedPart{1, 0, count}), rejected()[0]);
  EXPECT_TRUE(count == 1 || count == 2);
  std::vector<PartId> parts(scene.body(1).mesh.triangleCount(), 7);
  scene.setParts(1, parts);
  EXPECT_EQ((std::vector<RejectedPart>{{1, 7, count}}), rejected());
  scene.setPartPairEnabled(0, 0, 1, 7, false);
  EXPECT_TRUE(rejected().empty());
}

TEST_P(StatesSuite, LeaveOpenWhatAPoseTakesBeyondFloats) {
  Scene scene = pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0, 0));
  RigidTransform huge, large, strange, away;
  huge.rotation[0] = 1e39;
  large.rotation[0] = 1e38;
  strange.translation[1] = INFINITY;
  away.translation[2] = 1;
  const States states{{1}, {huge, large, strange, away}};
  const auto answers = expectSame(scene, states);
  EXPECT_EQ(PairDecision::kOpen, answers[0].decision);
  EXPECT_EQ(PairDecision::kContact, answers[1].decision);
  EXPECT_EQ(PairDecision::kOpen, answers[2].decision);
  EXPECT_EQ(PairDecision::kNone, answers[3].decision);
}

TEST_P(StatesSuite, EqualSingleDetectionsOfNothing) {
  Scene scene = pairScene(clothGrid(2, 1, 0, 0), {});
  expectSame(scene, {{0}, {RigidTransform()}});
  expectSame(scene, {{1}, {RigidTransform()}});
  expectSame(scene, {{0}, {}});
  expectSame(Scene(), {{}, {}});
  StateBatch none;
  none.count = 3;  // nothing is moved, so nothing is looked at
  const StateResults& results = checker_->check(scene, none, {});
  ASSERT_EQ(3U, results.states.size());
  for (const StateAnswer& answer : results.states) EXPECT_EQ(PairDecision::kNone, answer.decision);
}

TEST_P(StatesSuite, RefuseWhatIsWrong) {
  Scene scene = pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0, 0));
  const RigidTransform poses[2];
  const auto check = [&](const StateBatch& batch) { checker_->check(scene, batch, {}); };
  EXPECT_THROW(check({{2}, 1, poses}), std::invalid_argument);
  EXPECT_THROW(check({{0, 0}, 1, poses}), std::invalid_argument);
  EXPECT_THROW(check({{0}, 1, nullptr}), std::invalid_argument);
  EXPECT_THROW(check({{0}, std::size_t{1} << 32, poses}), std::invalid_argument);
  check({{0, 1}, 1, poses});
  check({{0}, 0, nullptr});
  if (checker_->backend() != "cpu") return;
  for (const int threads : {-1, 1025, std::numeric_limits<int>::max()}) {
    StateOptions options;
    options.threads = threads;
    EXPECT_THROW(checker_->check(scene, {{0}, 1, poses}, options), std::invalid_argument);
  }
}

INSTANTIATE_TEST_SUITE_P(, StatesSuite, ::testing::ValuesIn(stateBackends()), stateBackendName);

}  // namespace
}  // namespace deformable_contact_monitor
