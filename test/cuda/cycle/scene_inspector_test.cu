// Tests what is adapted after a cycle, on the host alone.
#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <cstdint>

#include "core/rules/intervals.h"
#include "cuda/cycle/scene_inspector.cuh"

namespace deformable_contact_monitor {
namespace {

// A cube around `middle` along x.
Aabb cube(float middle, float reach) {
  return {{middle - reach, -reach, -reach}, {middle + reach, reach, reach}};
}

// An inspector that is told the box of the tiles of each cycle.
class FrameOfTiles : public ::testing::Test {
 protected:
  FrameOfTiles() { startCold(); }

  void startCold() {
    ColdStart start;
    start.scale.origin = {5, 0, 0};
    start.scale.scale = 0.25;
    inspector_.setSeeds(start, Options());
  }

  void endCycle(const Aabb& tiles) {
    CycleCounters counted{};
    counted.clustered = 32000;
    for (int k = 0; k < 3; ++k) {
      if (tiles.empty()) continue;
      counted.tiles_box[k] = ~orderedBits(tiles.min[k]);
      counted.tiles_box[3 + k] = orderedBits(tiles.max[k]);
    }
    inspector_.beginCycle(Options());
    inspector_.endCycle(counted, Options(), 1, 2048, 32000, false);
    EXPECT_FALSE(inspector_.isCold());
  }
  double reach() const { return 1 / inspector_.frame().scale; }
  double middle() const { return inspector_.frame().origin.x; }
  bool has(const Aabb& box) const {
    return box.min.x >= middle() - reach() && box.max.x <= middle() + reach();
  }

  SceneInspector inspector_{{500, 8192, 100000, 132}};
};

TEST_F(FrameOfTiles, IsThatOfTheSceneAtFirst) {
  EXPECT_EQ(middle(), 5);
  EXPECT_EQ(reach(), 4);
  endCycle(Aabb());
  EXPECT_EQ(reach(), 4) << "a cycle without tiles tells nothing";
  endCycle(cube(0, 1000));
  startCold();
  EXPECT_EQ(reach(), 4);
  endCycle(cube(0, 1));
  EXPECT_NEAR(reach(), 2.5, 1e-6) << "nothing is left of the time before";
}

TEST_F(FrameOfTiles, FollowsAndHasRoomToMove) {
  for (int i = 0; i < 200; ++i) {
    const float at = 0.1F * static_cast<float>(i);
    endCycle(cube(at, 1));
    EXPECT_TRUE(has(cube(at + 0.1F, 1))) << "so far in the next cycle: " << at;
    EXPECT_LT(reach(), 8);
  }
  EXPECT_GT(middle(), 17);
}

TEST_F(FrameOfTiles, HasBothPlacesBetweenWhichASceneJumps) {
  for (int i = 0; i < 20; ++i) endCycle(cube(i % 2 == 0 ? 0 : 10, 1));
  EXPECT_TRUE(has(cube(0, 1)));
  EXPECT_TRUE(has(cube(10, 1)));
}

TEST_F(FrameOfTiles, ShrinksAfterAWhile) {
  endCycle(cube(0, 1000));
  EXPECT_NEAR(reach(), 2500, 1);
  for (int i = 0; i < 150; ++i) endCycle(cube(0, 0.001F));
  EXPECT_LT(reach(), 0.01);
}

TEST_F(FrameOfTiles, OfExtremesIsAFrame) {
  endCycle({{1, 1, 1}, {1, 1, 1}});
  EXPECT_EQ(middle(), 1);
  EXPECT_EQ(reach(), 0);
  endCycle({{1e38F, 0, 0}, {FLT_MAX, 1, 1}});
  EXPECT_TRUE(has({{1, 0, 0}, {FLT_MAX, 1, 1}}));
  EXPECT_TRUE(std::isfinite(middle()));
}

}  // namespace
}  // namespace deformable_contact_monitor
