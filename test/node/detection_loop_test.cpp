// Which meshes have which cycles, and what goes out when there are none.
#include "node/detection_loop.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "loop_fixture.h"

namespace deformable_contact_monitor {
namespace {

using MeshesTest = LoopTest;

TEST_F(MeshesTest, EveryMeshHasACycleAtItsStamp) {
  EXPECT_EQ(step(), Lines());
  give(0, 50);
  EXPECT_EQ(step(), Lines{"cycle 50: cloth@50 cable(no mesh yet)"});
  EXPECT_EQ(step(), Lines()) << "it was taken";
  give(1, 50.25);
  EXPECT_EQ(step(), Lines{"cycle 50.25: cloth@50 cable@50.25"});
}

TEST_F(MeshesTest, EqualStampsShareACycle) {
  give(0, 50);
  give(1, 50);
  EXPECT_EQ(step(), Lines{"cycle 50: cloth@50 cable@50"});
  EXPECT_EQ(step(), Lines());
}

TEST_F(MeshesTest, TheEarliestStampComesFirstAndTheNextAtOnce) {
  give(0, 50.25);
  give(1, 50);
  EXPECT_EQ(step(), Lines{"cycle 50: cloth(no mesh yet) cable@50"});
  EXPECT_LE(sleepMs(), 0);
  EXPECT_EQ(step(), Lines{"cycle 50.25: cloth@50.25 cable@50"});
}

TEST_F(MeshesTest, AMeshThatReplacesTheOneAboutToBeTakenHasItsOwnCycle) {
  step();
  give(0, 50);
  // The loop reads the clock for leftovers, then the stamps, then the clock for the rate.
  at_next_reading_ = [this] { at_next_reading_ = [this] { give(0, 50.25); }; };
  EXPECT_EQ(step(), Lines()) << "what waited at first was replaced and is dropped";
  EXPECT_EQ(meshes_[0].counters().dropped, 1U);
  EXPECT_LE(sleepMs(), 0) << "the newer one must not wait for anything";
  EXPECT_EQ(step(), Lines{"cycle 50.25: cloth@50.25 cable(no mesh yet)"});
}

TEST_F(MeshesTest, OneIsReplacedTheOtherOfThatStampIsNot) {
  step();
  give(0, 50);
  give(1, 50);
  at_next_reading_ = [this] { at_next_reading_ = [this] { give(0, 50.25); }; };
  EXPECT_EQ(step(), Lines{"cycle 50: cloth(no mesh yet) cable@50"});
  EXPECT_EQ(step(), Lines{"cycle 50.25: cloth@50.25 cable@50"});
}

TEST_F(MeshesTest, AnOlderMeshIsDroppedWithoutACycle) {
  give(0, 50);
  step();
  give(0, 49.75);
  EXPECT_EQ(step(), Lines());
  EXPECT_FALSE(meshes_[0].waitingStamp());
}

TEST_F(MeshesTest, MeshStampsThatGoBackReset) {
  give(0, 50);
  give(1, 50);
  step();
  give(0, 40);
  EXPECT_EQ(step(), (Lines{"end: time jump: mesh stamps went back",
                           "reset: time jump: mesh stamps went back",
                           "cycle 40: cloth@40 cable(no mesh yet)"}));
  EXPECT_EQ(detector_.resets, 1);
}

TEST_F(MeshesTest, ARefusedMeshWithASenselessStampHasACycleNow) {
  give(0, 0);
  EXPECT_EQ(step(),
            Lines{"cycle 50: cloth(mesh refused: header.stamp is zero) cable(no mesh yet)"});
  EXPECT_EQ(said_.refused, std::vector<std::uint64_t>{1});
  give(1, 90);
  const Lines said = step();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].find("cycle 50: "), 0U) << said[0];
  EXPECT_NE(said[0].find("ahead of this machine's clock"), std::string::npos) << said[0];
}

TEST_F(MeshesTest, CyclesKeepToTheRateAndTheNewestMeshWaits) {
  parameters_.max_rate_hz = 10;
  give(0, 50);
  EXPECT_EQ(step().size(), 1U);
  give(0, 50.125);
  EXPECT_EQ(stepAfter(60), Lines());
  EXPECT_EQ(sleepMs(), 40);
  give(0, 50.25);
  EXPECT_EQ(stepAfter(39), Lines());
  EXPECT_EQ(stepAfter(1), Lines{"cycle 50.25: cloth@50.25 cable(no mesh yet)"});
}

TEST_F(MeshesTest, AHeartbeatASecondWhileNothingComes) {
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(sleepMs(), 1000);
  EXPECT_EQ(stepAfter(999), Lines());
  EXPECT_EQ(stepAfter(1), Lines{"heartbeat 50: cloth(no mesh yet) cable(no mesh yet)"});
  EXPECT_EQ(sleepMs(), 1000);
  EXPECT_EQ(stepAfter(999), Lines());
  EXPECT_EQ(stepAfter(1).size(), 1U);
}

TEST_F(MeshesTest, AfterACycleTheHeartbeatWaitsUntilTheMeshIsTooOld) {
  parameters_.max_mesh_age_s = 2;
  give(0, 50);
  step();
  EXPECT_EQ(sleepMs(), 2000);
  ros_time_ = ros::Time(52.5);
  EXPECT_EQ(stepAfter(2000),
            Lines{"heartbeat 52.5: cloth(newest mesh is 2.500000 s old) cable(no mesh yet)"});
}

TEST_F(MeshesTest, AHeartbeatSaysThatItFoundNoNewMesh) {
  give(0, 50);
  step();
  EXPECT_EQ(stepAfter(1000), Lines{"heartbeat 50: cloth(no new mesh) cable(no mesh yet)"});
}

TEST_F(MeshesTest, ADetectorThatThrowsCostsOneCycle) {
  detector_.failure = "out of memory";
  give(0, 50);
  EXPECT_EQ(step(), (Lines{"error: out of memory", "no result 50: cloth@50 cable(no mesh yet)"}));
  detector_.failure.clear();
  give(0, 50.25);
  EXPECT_EQ(step(), Lines{"cycle 50.25: cloth@50.25 cable(no mesh yet)"});
}

TEST_F(MeshesTest, AStepThatFailsIsTriedAgainInASecond) {
  robot_source_ = []() -> std::shared_ptr<const RobotGeometry> { throw std::bad_alloc(); };
  give(0, 50);
  EXPECT_EQ(step(), Lines{"error: std::bad_alloc"});
  EXPECT_EQ(sleepMs(), 1000);
  robot_source_ = nullptr;
  EXPECT_EQ(step(), Lines{"cycle 50: cloth@50 cable(no mesh yet)"}) << "or when something comes";
}

// What the monitor's threads do. A race is for ThreadSanitizer to find.
TEST_F(MeshesTest, MeshesAndRequestsComeFromOtherThreads) {
  Lines said;
  std::thread detection([&] {
    while (requests_.wait(std::chrono::steady_clock::now() + std::chrono::milliseconds(1))) {
      for (const std::string& line : step()) said.push_back(line);
    }
  });
  std::thread publisher([&] {
    for (int i = 0; i <= 256; ++i) {
      give(0, 49.5 + i / 1024.0);
      requests_.wake();
    }
  });
  for (int i = 0; i < 20; ++i) {
    requests_.requestReset();
    requests_.setEnabled(true);
    requests_.addAllowedContacts({});
  }
  publisher.join();
  while (meshes_[0].waitingStamp()) std::this_thread::yield();
  requests_.stop();
  detection.join();
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(std::count(said.begin(), said.end(), "cycle 49.75: cloth@49.75 cable(no mesh yet)"), 1);
}

}  // namespace
}  // namespace deformable_contact_monitor
