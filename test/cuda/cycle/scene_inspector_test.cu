// Tests when a cycle starts cold, on the host alone.
#include <gtest/gtest.h>

#include <cstdint>

#include "cuda/cycle/scene_inspector.cuh"

namespace deformable_contact_monitor {
namespace {

// The next cycle starts cold once the frame of rounded boxes suits an eighth of the tiles no more.
TEST(SceneInspector, StartsColdWhenTilesDoNotFitTheirFrame) {
  SceneInspector inspector({500, 8192, 1600, 132});
  const auto isColdAfter = [&inspector](std::uint32_t misfits, bool started_cold) {
    CycleCounters counted{};
    counted.clustered = 32000;
    counted.misfits = misfits;
    inspector.beginCycle(Options());
    Options options;
    options.clusters = 4;
    inspector.endCycle(counted, options, 4, 2048, 32000, started_cold);
    return inspector.isCold();
  };
  EXPECT_FALSE(isColdAfter(300, true)) << "a frame is made once";
  EXPECT_FALSE(isColdAfter(420, false));
  EXPECT_TRUE(isColdAfter(440, false));
  EXPECT_FALSE(isColdAfter(440, true));
  EXPECT_FALSE(isColdAfter(0, false));
  EXPECT_FALSE(isColdAfter(560, false));
  EXPECT_TRUE(isColdAfter(580, false));
}

}  // namespace
}  // namespace deformable_contact_monitor
