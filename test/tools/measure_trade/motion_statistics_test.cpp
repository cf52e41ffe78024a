// Tests the counts of contacts that are missed if all frames are checked, and if only some are. The
// contacts of the scenes are worked out by hand.
#include <gtest/gtest.h>

#include <stdexcept>
#include <utility>

#include "reference/reference_detectors.h"
#include "scenes.h"
#include "tools/measure_trade/motion_measurement.h"

namespace deformable_contact_monitor {
namespace {

constexpr MotionLevel kLevels[] = {MotionLevel::kBodies, MotionLevel::kTriangles};

// Needles of a quarter's length above a floor at z = 0, which they touch iff their tips are at
// z in [-1/4, 0]. Two of them, side by side.
class Needles : public FrameSource {
 public:
  struct Place {
    double x = 0, z = 0;
    bool enabled = true;
    bool turned = false;  // its triangles the other way round
    bool has_path = true;
  };

  explicit Needles(std::vector<Place> places) : places_(std::move(places)) {
    scene_.addBody("needles", needles(false));
    scene_.addBody("floor", meshOf({{{{-4, -4, 0}, {4, -4, 0}, {0, 8, 0}}}}));
  }

  bool next() override {
    if (next_ == places_.size()) return false;
    const Place& place = places_[next_];
    if (place.turned != turned_) scene_.setMesh(0, needles(place.turned));
    turned_ = place.turned;
    RigidTransform pose;
    pose.translation[0] = place.x;
    pose.translation[2] = place.z;
    scene_.setPose(0, pose);
    scene_.setPairEnabled(0, 1, place.enabled);
    ++next_;
    return true;
  }
  bool isDeformable(BodyId body) const override { return body == 0; }
  bool hasPath(BodyId body) const override { return body == 1 || places_[next_ - 1].has_path; }
  std::string label() const override { return "frame " + std::to_string(next_ - 1); }

 private:
  static TriangleMesh needles(bool turned) {
    const float far = 0.25F;
    TriangleMesh mesh = meshOf({{{{0, 0, 0}, {0.1F, 0, far}, {0, 0.1F, far}}},
                                {{{1, 0, 0}, {1.1F, 0, far}, {1, 0.1F, far}}}});
    if (turned) std::swap(mesh.triangles[0], mesh.triangles[1]);
    return mesh;
  }

  std::vector<Place> places_;
  bool turned_ = false;
};

MotionResults motionsOf(std::vector<Needles::Place> places, std::size_t every) {
  Needles frames(std::move(places));
  return findMotions(&frames, every, Options(), makeBruteForceDetector, [](const std::string&) {});
}

// Through the floor between two frames; up again, seen in two frames; kept: 0, 4 and 8.
MotionResults throughAndBack() {
  return motionsOf(
      {{0, 1}, {0, 0.5}, {0, -0.5}, {0, -1}, {0, -1}, {0, -0.125}, {0, -0.125}, {0, 0.5}, {0, 1}},
      4);
}

TEST(MotionSteps, KeptFramesAreEachSoManyThAndTheLast) {
  EXPECT_EQ(keptFrames(9, 4), (std::vector<std::size_t>{0, 4, 8}));
  EXPECT_EQ(keptFrames(10, 4), (std::vector<std::size_t>{0, 4, 8, 9}));
  EXPECT_EQ(keptFrames(1, 4), (std::vector<std::size_t>{0}));
}

TEST(MotionSteps, AreFromFrameToFrame) {
  const MotionResults found = throughAndBack();
  ASSERT_EQ(found.steps.size(), 8U);
  ASSERT_EQ(found.kept_steps.size(), 2U);
  EXPECT_EQ(found.labels[3], "frame 3");
  for (std::size_t i = 0; i < found.steps.size(); ++i) {
    EXPECT_EQ(std::make_pair(found.steps[i].from, found.steps[i].to), std::make_pair(i, i + 1));
    EXPECT_EQ(found.steps[i].contacts.size(), i == 1 || (i >= 4 && i <= 6) ? 2U : 0U) << i;
    EXPECT_EQ(found.instant[i].size(), i == 5 || i == 6 ? 2U : 0U) << i;
  }
  EXPECT_EQ(std::make_pair(found.kept_steps[1].from, found.kept_steps[1].to),
            (std::pair<std::size_t, std::size_t>(4, 8)));
  EXPECT_EQ(found.kept_steps[0].contacts.size(), 2U);
  EXPECT_EQ(found.pairs_without_step, 0U);
}

TEST(MotionSteps, TheLastFrameIsKeptToo) {
  const MotionResults found = motionsOf({{0, 1}, {0, 1}, {0, 1}, {0, -1}}, 2);
  ASSERT_EQ(found.kept_steps.size(), 2U);
  EXPECT_EQ(found.kept_steps[1].from, 2U);
  EXPECT_EQ(found.kept_steps[1].to, 3U);
  EXPECT_EQ(found.kept_steps[1].contacts.size(), 2U);
}

TEST(MotionSteps, NeedMoreFramesThanAreLeftOut) {
  EXPECT_THROW(motionsOf({{0, 1}, {0, 0}}, 2), std::runtime_error);
  EXPECT_NO_THROW(motionsOf({{0, 1}, {0, 0}, {0, 1}}, 2));
}

TEST(MotionStatistics, WhatEachWayLoses) {
  const MotionResults found = throughAndBack();
  const std::uint64_t lost[] = {1, 2, 0};  // of two, by waysToLook()
  for (const MotionLevel level : kLevels) {
    const std::uint64_t of_each = level == MotionLevel::kBodies ? 1 : 2;
    const std::vector<Onset> truth = trueOnsets(found, level);
    ASSERT_EQ(truth.size(), 2 * of_each);
    for (std::size_t way = 0; way < 3; ++way) {
      const PairCounts contacts = lostContacts(found, waysToLook()[way], level);
      EXPECT_EQ(contacts.truth, 2 * of_each);
      EXPECT_EQ(contacts.lost(), lost[way] * of_each) << way;
      EXPECT_EQ(contacts.added(), 0U);
      const FoundOnsets onsets = findOnsets(found, waysToLook()[way], level, truth);
      EXPECT_EQ(onsets.lost(), lost[way] * of_each) << way;
      EXPECT_EQ(onsets.added, 0U);
    }
  }
}

TEST(MotionStatistics, Times) {
  const MotionResults found = throughAndBack();
  const std::vector<Onset> truth = trueOnsets(found, MotionLevel::kBodies);
  ASSERT_EQ(truth.size(), 2U);
  constexpr double kNear = 1e-5;
  EXPECT_NEAR(truth[0].low, 1.5, kNear);
  EXPECT_NEAR(truth[1].low, 4 + 0.75 / 0.875, kNear);
  EXPECT_LE(truth[0].low, 1.5);
  EXPECT_GE(truth[0].high, 1.5);

  const FoundOnsets instant = findOnsets(found, waysToLook()[0], MotionLevel::kBodies, truth);
  EXPECT_FALSE(instant.of_truth[0]);
  ASSERT_TRUE(instant.of_truth[1]);
  EXPECT_EQ(instant.of_truth[1]->low, 5);
  EXPECT_NEAR(timeError(truth, instant).mean, 1 - 0.75 / 0.875, kNear);

  const FoundOnsets swept = findOnsets(found, waysToLook()[2], MotionLevel::kBodies, truth);
  ASSERT_TRUE(swept.of_truth[0] && swept.of_truth[1]);
  EXPECT_NEAR(swept.of_truth[0]->low, 2, kNear);    // half of the way from 1 to -1
  EXPECT_NEAR(swept.of_truth[1]->low, 5.5, kNear);  // three eighths of the way back
  EXPECT_NEAR(timeError(truth, swept).worst, 5.5 - 4 - 0.75 / 0.875, kNear);
  EXPECT_NEAR(timeError(truth, swept).mean, (0.5 + 1.5 - 0.75 / 0.875) / 2, kNear);

  const FoundOnsets none = findOnsets(found, waysToLook()[1], MotionLevel::kBodies, truth);
  EXPECT_EQ(timeError(truth, none).worst, 0);
}

TEST(MotionStatistics, AStraightWayThatIsNotTheTrueOneIsSaid) {
  const MotionResults found = motionsOf({{0, 1}, {20, 1}, {20, -1}, {0, -1}}, 3);
  const PairCounts contacts = lostContacts(found, waysToLook()[2], MotionLevel::kTriangles);
  EXPECT_EQ(contacts.truth, 0U);
  EXPECT_EQ(contacts.added(), 2U);
  const FoundOnsets onsets = findOnsets(found, waysToLook()[2], MotionLevel::kTriangles, {});
  EXPECT_EQ(onsets.added, 2U);
  EXPECT_EQ(findOnsets(found, waysToLook()[1], MotionLevel::kTriangles, {}).added, 0U);
}

TEST(MotionStatistics, OfSeveralInOneIntervalTheFirstIsFound) {
  const MotionResults found = motionsOf({{0, 1}, {0, -1}, {0, 1}, {0, -1}}, 3);
  const std::vector<Onset> truth = trueOnsets(found, MotionLevel::kBodies);
  ASSERT_EQ(truth.size(), 3U);
  const FoundOnsets swept = findOnsets(found, waysToLook()[2], MotionLevel::kBodies, truth);
  EXPECT_TRUE(swept.of_truth[0]);
  EXPECT_EQ(swept.lost(), 2U);
  // It is one contact of the stretch, and found.
  const PairCounts contacts = lostContacts(found, waysToLook()[2], MotionLevel::kBodies);
  EXPECT_EQ(std::make_pair(contacts.truth, contacts.lost()),
            (std::pair<std::uint64_t, std::uint64_t>(1, 0)));
}

TEST(MotionStatistics, WhatIsThereFromTheBeginningHasNoOnset) {
  const MotionResults found = motionsOf({{0, -0.125}, {0, -0.125}, {0, 1}}, 2);
  EXPECT_TRUE(trueOnsets(found, MotionLevel::kTriangles).empty());
  EXPECT_EQ(lostContacts(found, waysToLook()[1], MotionLevel::kTriangles).lost(), 0U);
}

TEST(MotionStatistics, WhatWasNotLookedAtBeforeHasNoStepAndNoOnset) {
  const MotionResults off = motionsOf({{0, 1}, {0, 1, false}, {0, -0.125}, {0, -0.125}, {0, 1}}, 4);
  EXPECT_EQ(off.pairs_without_step, 1U);
  EXPECT_TRUE(trueOnsets(off, MotionLevel::kBodies).empty());
  EXPECT_TRUE(off.steps[1].contacts.empty());
  EXPECT_EQ(off.steps[2].contacts.size(), 2U);
  for (const MotionWay& way : waysToLook()) {
    EXPECT_EQ(findOnsets(off, way, MotionLevel::kBodies, {}).added, 0U);
  }

  const MotionResults changed =
      motionsOf({{0, 1}, {0, -0.125, true, true}, {0, 1, true, true}, {0, 1, true, true}}, 3);
  EXPECT_EQ(changed.pairs_without_step, 1U);
  EXPECT_TRUE(trueOnsets(changed, MotionLevel::kBodies).empty());
  EXPECT_EQ(lostContacts(changed, waysToLook()[0], MotionLevel::kBodies).truth, 1U);
}

// The needles were above the floor and are below it, and nobody knows how they came there.
TEST(MotionStatistics, WhatWasAwayHasNoStep) {
  const MotionResults away =
      motionsOf({{0, 1}, {0, 1}, {0, -1, true, false, false}, {0, -1}, {0, -1}, {0, 1}}, 3);
  EXPECT_EQ(away.pairs_without_step, 1U);
  EXPECT_TRUE(away.steps[1].contacts.empty());
  EXPECT_TRUE(away.kept_steps[0].contacts.empty());
  EXPECT_TRUE(away.kept_steps[0].bodies.empty());
  EXPECT_EQ(away.kept_steps[1].contacts.size(), 2U);
  EXPECT_EQ(trueOnsets(away, MotionLevel::kBodies).size(), 1U);
}

}  // namespace
}  // namespace deformable_contact_monitor
