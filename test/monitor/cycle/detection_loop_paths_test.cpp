// Tests of continuous collision detection in the detection loop: paths of links, and of objects in
// frames that move.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "steps_fixture.h"

namespace deformable_contact_monitor {
namespace {

bool isSame(const RigidTransform& a, const RigidTransform& b) {
  return std::equal(std::begin(a.rotation), std::end(a.rotation), std::begin(b.rotation)) &&
         std::equal(std::begin(a.translation), std::end(a.translation), std::begin(b.translation));
}

class PathsTest : public StepsTest {
 protected:
  PathsTest() {
    useRobot(1);
    parameters_.pair_classes = {true, false, false, false};
  }

  const BodyPath& path(BodyId id) const { return said_.sweeps.at(0).bodies.at(id).path; }
};

TEST_F(PathsTest, ALinkThatMovesHasAPathByItsTransforms) {
  for (int i = 0; i <= 4; ++i) addTransform(&transforms_, "link0", 50 + i / 32.0, 0.1 * i * i);
  give(0, 50, "base", -1);
  step();
  give(0, 50.125, "base", -2);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cloth: link0/cloth"});
  const TransformLookup lookup(transforms_, "base");
  ASSERT_FALSE(path(0).empty());
  EXPECT_EQ(path(0).front().at, 0);
  EXPECT_TRUE(isSame(path(0).front().pose, said_.sweeps[0].bodies[0].pose));
  EXPECT_EQ(path(0).back().at, 1);
  for (std::size_t i = 0; i < path(0).size(); ++i) {
    const double at_s = 0.125 * path(0)[i].at;
    EXPECT_TRUE(i == 0 || at_s - 0.125 * path(0)[i - 1].at <= 0.01);
    ros::Time stamp;
    stamp.fromNSec(50000000000ULL + static_cast<std::uint64_t>(std::llround(1e9 * at_s)));
    EXPECT_TRUE(isSame(path(0)[i].pose, lookup.lookup({{"link0", stamp}})[0].pose)) << at_s;
  }
  EXPECT_TRUE(path(1).empty()) << "the cloth is in the reference frame";
}

TEST_F(PathsTest, ALinkThatStandsHasNone) {
  for (int i = 0; i <= 4; ++i) addTransform(&transforms_, "link0", 50 + i / 32.0, 0.7);
  give(0, 50);
  step();
  give(0, 50.125);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cloth: link0/cloth"});
  EXPECT_TRUE(path(0).empty());
}

TEST_F(PathsTest, ALinkThatCameBackHasOne) {
  for (int i = 0; i <= 4; ++i) addTransform(&transforms_, "link0", 50 + i / 32.0, i == 2 ? 1 : 0);
  give(0, 50);
  step();
  give(0, 50.125);
  step();
  EXPECT_FALSE(path(0).empty());
}

TEST_F(PathsTest, ALinkThatWasNotKnownCostsItsPairsAlone) {
  useRobot(2);
  addTransform(&transforms_, "link0", 50);
  addTransform(&transforms_, "link0", 51);
  give(0, 50);
  step();
  addTransform(&transforms_, "link1", 50);
  addTransform(&transforms_, "link1", 51);
  give(0, 50.125);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cloth: link0/cloth link1/cloth (link1: not known in the previous "
                           "cycle)"});
}

TEST_F(PathsTest, AnObjectWhoseFrameTurnsHasOne) {
  addTransform(&transforms_, "link0", 50);
  addTransform(&transforms_, "link0", 51);
  addTransform(&transforms_, "camera", 50);
  addTransform(&transforms_, "camera", 51, 0.5);
  give(0, 50, "camera", -2);
  step();
  give(0, 50.125, "camera", -3);
  step();
  EXPECT_EQ(steps(), Lines{"50 of cloth: link0/cloth"});
  EXPECT_FALSE(path(1).empty());
  EXPECT_EQ(earlierZ(0), -2);
}

// The buffer has no transform between the two cycles any more. The poses at both ends are known
// from the cycles.
TEST_F(PathsTest, WithoutTransformsInBetweenThereIsNone) {
  addTransform(&transforms_, "link0", 50);
  give(0, 50);
  step();
  transforms_.clear();
  addTransform(&transforms_, "link0", 50.125);
  give(0, 50.125);
  step();
  ASSERT_EQ(steps().size(), 1U);
  EXPECT_NE(steps()[0].find("(link0: between the cycles: TF from 'link0' to 'base' no longer"),
            std::string::npos)
      << steps()[0];
}

TEST_F(PathsTest, TheRobotsOwnCyclesHaveStepsOfTheirOwn) {
  useRobot(2);
  parameters_.pair_classes = {false, false, false, true};
  for (const char* const link : {"link0", "link1"}) addTransform(&transforms_, link, 50);
  step();
  EXPECT_EQ(steps(),
            Lines{"0 of link0 link1: link0/link1 (link0: the robot came) (link1: the robot "
                  "came)"});
  addTransform(&transforms_, "link0", 50.125, 0.5);
  addTransform(&transforms_, "link1", 50.125);
  stepAfter(200, 125);
  EXPECT_EQ(steps(), Lines{"50 of link0 link1: link0/link1"});
  EXPECT_FALSE(path(0).empty());
  EXPECT_TRUE(path(1).empty());
}

// Readers take no state of that stamp for known.
TEST_F(PathsTest, TheRobotsOwnCycleIsOfThePresentIfTransformsAreAheadOfTheClock) {
  useRobot(2);
  parameters_.pair_classes = {false, false, false, true};
  for (const char* const link : {"link0", "link1"}) {
    addTransform(&transforms_, link, 49);
    addTransform(&transforms_, link, 50.0625);
  }
  EXPECT_EQ(step().back(), "cycle 50.0625: *link0@50.0625 *link1@50.0625 cloth cable");
  for (const char* const link : {"link0", "link1"}) addTransform(&transforms_, link, 50.125);
  EXPECT_EQ(stepAfter(200).back(), "cycle 50: *link0@50 *link1@50 cloth cable");
}

// Its clock may be wrong, or it predicts.
TEST_F(PathsTest, ALinkThatStampsAheadHidesNoOther) {
  useRobot(3);
  parameters_.pair_classes = {false, false, false, true};
  for (const char* const link : {"link0", "link1", "link2"}) addTransform(&transforms_, link, 49);
  for (const char* const link : {"link0", "link1"}) addTransform(&transforms_, link, 49.9375);
  addTransform(&transforms_, "link2", 50.75);
  EXPECT_EQ(step().back(),
            "cycle 49.9375: *link0@49.9375 *link1@49.9375 *link2@49.9375 cloth cable");
}

// States are known for 0.5 s, and the loop looks each 0.033 s.
TEST_F(PathsTest, TheOthersGoOnWithoutALinkThatStoppedBeforeTheirStatesAreTooOld) {
  useRobot(3);
  parameters_.pair_classes = {false, false, false, true};
  parameters_.max_mesh_age_s = 0.5;
  const double start_s = ros_time_.toSec();
  for (const char* const link : {"link0", "link1", "link2"}) {
    addTransform(&transforms_, link, start_s);
  }
  EXPECT_FALSE(step().empty());
  std::vector<double> stamps_s;  // of cycles, after the start
  for (int tenth = 1; tenth <= 10; ++tenth) {
    const double stamp_s = start_s + tenth * 0.0625;
    for (const char* const link : {"link0", "link1"}) addTransform(&transforms_, link, stamp_s);
    const Lines lines = stepAfter(100, 62);
    if (lines.empty()) continue;
    stamps_s.push_back(stamp_s - start_s);
    std::ostringstream known;
    known << "*link0@" << stamp_s << " *link1@" << stamp_s << " ";
    EXPECT_NE(lines.back().find(known.str()), std::string::npos) << lines.back();
    EXPECT_NE(lines.back().find("TF from 'link2' to 'base' is late"), std::string::npos);
  }
  EXPECT_EQ(stamps_s, (std::vector<double>{0.5, 0.5625, 0.625}));
}

// It then says which transforms are late.
TEST_F(PathsTest, TheRobotsOwnCycleIsOfThePresentIfTransformsAreTooOld) {
  useRobot(2);
  parameters_.pair_classes = {false, false, false, true};
  addTransform(&transforms_, "link0", 49);
  addTransform(&transforms_, "link1", 49);
  const auto isOfThePresent = [this](int ms) {
    const Lines lines = stepAfter(ms, ms);
    const std::string late = "TF from 'link0' to 'base' is late: wanted " +
                             std::to_string(ros_time_.toSec()).substr(0, 6);
    return !lines.empty() && lines.back().find(late) != std::string::npos;
  };
  EXPECT_TRUE(isOfThePresent(0));
  EXPECT_TRUE(isOfThePresent(100));
  // Those that come with a delay are news all the same.
  for (const char* const link : {"link0", "link1"}) addTransform(&transforms_, link, 50.0625);
  EXPECT_EQ(stepAfter(100, 25).back(), "cycle 50.0625: *link0@50.0625 *link1@50.0625 cloth cable");
  EXPECT_TRUE(stepAfter(100, 100).empty()) << "nothing new";
  EXPECT_TRUE(isOfThePresent(500)) << "they have stopped";
}

}  // namespace
}  // namespace deformable_contact_monitor
