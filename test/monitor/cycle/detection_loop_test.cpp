// Tests of which meshes have which cycles, and of what is published without meshes.
#include "monitor/cycle/detection_loop.h"

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
  EXPECT_EQ(step(), Lines{"cycle 50: *cloth@50 cable(no mesh yet)"});
  EXPECT_EQ(step(), Lines()) << "it was taken";
  give(1, 50.25);
  EXPECT_EQ(step(), Lines{"cycle 50.25: cloth@50 *cable@50.25"});
}

TEST_F(MeshesTest, EqualStampsShareACycle) {
  give(0, 50);
  give(1, 50);
  EXPECT_EQ(step(), Lines{"cycle 50: *cloth@50 *cable@50"});
  EXPECT_EQ(step(), Lines());
}

// One object's stamps are half a second behind the other's, at the same rate. Neither takes the
// other's cycles.
TEST_F(MeshesTest, ObjectsTakeTurnsWhateverTheirStamps) {
  give(0, 50.25);
  give(1, 50);
  EXPECT_EQ(step(), Lines{"cycle 50.25: *cloth@50.25 cable@50"});
  EXPECT_LE(sleepMs(), 0);
  give(0, 50.3125);
  EXPECT_EQ(step().front(), "cycle 50: cloth(no mesh as old as this cycle) *cable@50");
  give(1, 50.0625);
  EXPECT_EQ(step().front(), "cycle 50.3125: *cloth@50.3125 cable@50.0625");
  give(0, 50.375);
  EXPECT_EQ(step().front().substr(0, 13), "cycle 50.0625");
}

TEST_F(MeshesTest, OfManyObjectsNoneStarves) {
  constexpr std::size_t kObjects = 20;
  for (std::size_t i = 2; i < kObjects; ++i) {
    parameters_.objects.push_back({"object" + std::to_string(i), "", 0, true});
  }
  std::vector<int> cycles(kObjects);
  // Meshes come faster than there are cycles; the first object's stamps are always the earliest.
  for (std::size_t round = 0; round < 5 * kObjects; ++round) {
    ros_time_ = ros::Time(50 + 0.01 * static_cast<double>(round));
    for (std::size_t i = 0; i < kObjects; ++i) {
      give(i, ros_time_.toSec() - (i == 0 ? 0.25 : 0.001 * static_cast<double>(i)));
    }
    for (const std::string& line : step()) {
      const std::size_t star = line.find('*');
      const std::string name = line.substr(star + 1, line.find('@', star) - star - 1);
      for (std::size_t i = 0; i < kObjects; ++i) cycles[i] += parameters_.objects[i].name == name;
    }
  }
  EXPECT_EQ(cycles, std::vector<int>(kObjects, 5));
}

TEST_F(MeshesTest, OfMeshesThatComeBetweenCyclesTheNewestWaits) {
  step();
  give(0, 50);
  give(0, 50.25);
  EXPECT_EQ(step(), Lines{"cycle 50.25: *cloth@50.25 cable(no mesh yet)"});
  EXPECT_EQ(meshes()[0].counters().dropped, 1U);
}

// This holds however long the mesh has to wait for its turn.
TEST_F(MeshesTest, OfMeshesThatComeBeforeTheirTurnTheNewestHasTheCycle) {
  give(0, 50);
  give(1, 50.0625);
  EXPECT_EQ(step(), Lines{"cycle 50: *cloth@50 cable(no mesh as old as this cycle)"});
  give(1, 50.125);
  give(1, 50.25);
  give(0, 50.25);
  EXPECT_EQ(step(), Lines{"cycle 50.25: *cloth@50.25 *cable@50.25"});
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(meshes()[1].counters().dropped, 2U);
  EXPECT_EQ(meshes()[0].counters().dropped, 0U);
}

TEST_F(MeshesTest, AnOlderMeshReplacesNoneThatWaits) {
  give(0, 50);
  give(1, 50.0625);
  step();
  give(1, 50);
  EXPECT_EQ(step(), Lines{"cycle 50.0625: cloth@50 *cable@50.0625"});
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(meshes()[1].counters().dropped, 1U);
}

TEST_F(MeshesTest, AMeshThatComesWhileAnotherIsTakenHasItsOwnCycle) {
  step();
  give(0, 50);
  // The second mesh arrives while the cycle of the first one runs.
  at_cycle_ = [this] { give(0, 50.25); };
  EXPECT_EQ(step(), Lines{"cycle 50: *cloth@50 cable(no mesh yet)"});
  EXPECT_LE(sleepMs(), 0) << "the newer one must not wait for anything";
  EXPECT_EQ(step(), Lines{"cycle 50.25: *cloth@50.25 cable(no mesh yet)"});
  EXPECT_EQ(meshes()[0].counters().dropped, 0U);
}

TEST_F(MeshesTest, AnOlderMeshIsDroppedWithoutACycle) {
  give(0, 50);
  step();
  give(0, 49.75);
  EXPECT_EQ(step(), Lines());
  EXPECT_FALSE(meshes()[0].hasWaiting());
}

TEST_F(MeshesTest, StampsThatGoBackConcernTheirObjectAlone) {
  parameters_.max_mesh_age_s = 0.25;
  give(0, 50.5);
  give(1, 50);
  step();
  step();
  give(0, 50);
  EXPECT_EQ(step(), (Lines{"forget cloth: the stamps of its meshes went back",
                           "cycle 50: *cloth@50 cable@50"}));
  EXPECT_EQ(detector_.resets, 0);
  give(1, 50.125);
  EXPECT_EQ(step(), Lines{"cycle 50.125: cloth@50 *cable@50.125"});
}

TEST_F(MeshesTest, ARefusedMeshMakesItsObjectUnknownNow) {
  give(1, 50);
  step();
  give(0, 0);
  EXPECT_EQ(step(), Lines{"cycle 50: *cloth(mesh refused: header.stamp is zero) cable"});
  EXPECT_EQ(meshes()[0].counters().rejected, 1U);
  EXPECT_EQ(meshes()[1].counters().rejected, 0U);
  give(1, 90);
  const Lines said = step();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].find("cycle 50: cloth(mesh refused: header.stamp is zero) *cable(mesh refused"),
            0U)
      << said[0];
  EXPECT_NE(said[0].find("ahead of this machine's clock"), std::string::npos) << said[0];
  EXPECT_EQ(detector_.resets, 0);
}

// Such meshes come from a bag that is played without its clock.
TEST_F(MeshesTest, AMeshThatIsTooOldIsNothingKnown) {
  give(0, 1);
  const Lines said = step();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].find("cycle 50: *cloth(mesh refused: header.stamp is 49.0"), 0U) << said[0];
}

TEST_F(MeshesTest, EachObjectKeepsToTheRateAndTheNewestMeshWaits) {
  parameters_.max_rate_hz = 10;
  give(0, 50);
  EXPECT_EQ(step().size(), 1U);
  give(0, 50.125);
  EXPECT_EQ(stepAfter(60), Lines());
  EXPECT_EQ(sleepMs(), 40);
  give(1, 50);
  EXPECT_EQ(step(), Lines{"cycle 50: cloth@50 *cable@50"}) << "it has a rate of its own";
  give(0, 50.25);
  EXPECT_EQ(stepAfter(39), Lines());
  EXPECT_EQ(stepAfter(1), Lines{"cycle 50.25: *cloth@50.25 cable@50"});
}

TEST_F(MeshesTest, AHeartbeatASecondWhileNothingComes) {
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(sleepMs(), 250) << "until UNKNOWN objects are shown again";
  EXPECT_EQ(stepAfter(999), Lines());
  EXPECT_EQ(stepAfter(1), (Lines{"forget all: no new mesh",
                                 "heartbeat 50: cloth(no mesh yet) cable(no mesh yet)"}));
  EXPECT_GT(sleepMs(), 0);
  EXPECT_EQ(stepAfter(999), Lines());
  EXPECT_EQ(stepAfter(1).size(), 2U);
}

// Publishers of markers delete an object before they draw it anew.
TEST_F(MeshesTest, ADeletionIsNoGapWhereAMeshFollowsSoon) {
  const auto deleteCloth = [this] {
    IncomingMesh mesh{boost::make_shared<DeformableMesh>(), "deleted"};
    mesh.is_deletion = true;
    mesh.arrival = steady_time_;
    meshes()[0].store(mesh);
  };
  step();
  for (int i = 0; i < 10; ++i) {
    const double stamp_s = 50 + i / 10.0;
    ros_time_ = ros::Time(stamp_s);
    deleteCloth();
    EXPECT_EQ(stepAfter(10), Lines()) << i;
    EXPECT_LE(sleepMs(), 200) << "it ends by itself";
    give(0, stamp_s);
    const Lines said = stepAfter(10);
    ASSERT_EQ(said.size(), 1U) << i;
    EXPECT_NE(said[0].find("*cloth@"), std::string::npos) << said[0];
    EXPECT_EQ(stepAfter(80), Lines());
  }
  deleteCloth();
  ros_time_ = ros::Time(51);
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(stepAfter(150), Lines());
  deleteCloth();
  EXPECT_EQ(stepAfter(49), Lines()) << "a second one puts nothing off";
  EXPECT_EQ(stepAfter(1), Lines{"cycle 51: *cloth(mesh refused: deleted) cable(no mesh yet)"});
}

TEST_F(MeshesTest, ADeletionsGraceIsThatOfTheSimulator) {
  is_simulated_ = true;
  give(0, 50);
  step();
  IncomingMesh mesh{boost::make_shared<DeformableMesh>(), "deleted"};
  mesh.is_deletion = true;
  mesh.arrival = steady_time_;
  meshes()[0].store(mesh);
  EXPECT_EQ(step(), Lines());
  EXPECT_EQ(stepAfter(900, 199), Lines());
  EXPECT_EQ(stepAfter(10, 1).size(), 1U);
}

// An object without a cycle is shown all the same, so that it does not vanish from rviz.
TEST_F(MeshesTest, WhatIsUnknownIsShownFourTimesASecond) {
  step();
  give(0, 50);
  stepAfter(10);
  stepAfter(240);
  EXPECT_EQ(said_.shown, "cable(no mesh yet)");
  EXPECT_TRUE(said_.has_scene);
  ros_time_ = ros::Time(51);
  stepAfter(249);
  EXPECT_EQ(said_.shown, "cable(no mesh yet)");
  EXPECT_LE(sleepMs(), 1);
  stepAfter(1);
  EXPECT_EQ(said_.shown, "cloth(newest mesh is 1.000 s old)cable(no mesh yet)");
  give(0, 51);
  give(1, 51);
  step();
  said_.shown = "";
  stepAfter(250);
  EXPECT_EQ(said_.shown, "") << "all is known";
}

// Nobody knows how old a mesh is without a clock, so no mesh has a cycle until there is one.
TEST_F(MeshesTest, WithoutAClockNothingIsKnown) {
  is_simulated_ = true;
  ros_time_ = ros::Time();
  parameters_.pair_classes.deformable_self = true;
  const std::string none = "(no clock: use_sim_time is set, and nothing came on /clock)";
  step();
  for (int i = 1; i < 30; ++i) {
    give(0, 50 + i / 30.0);
    give(1, 50 + i / 30.0);
    EXPECT_EQ(stepAfter(33), Lines()) << i;
    EXPECT_GT(sleepMs(), 0) << "nothing is polled";
  }
  EXPECT_EQ(stepAfter(100), (Lines{"forget all: no clock: use_sim_time is set, and nothing came on "
                                   "/clock",
                                   "heartbeat 0: cloth" + none + " cable" + none}));
  ros_time_ = ros::Time(51);
  give(0, 51);
  EXPECT_EQ(step(), Lines{"cycle 51: *cloth@51 cable(no mesh yet)"});
  ros_time_ = ros::Time();
  give(0, 51.1);
  const Lines said = step();
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said.front().substr(0, 29), "forget all: time jump: the cl") << said.front();
  EXPECT_EQ(said.back().find("cycle"), std::string::npos) << said.back();
}

TEST_F(MeshesTest, AfterACycleTheHeartbeatWaitsUntilTheMeshIsTooOld) {
  parameters_.max_mesh_age_s = 2;
  give(0, 50);
  step();
  step();
  EXPECT_GT(sleepMs(), 0) << "for the UNKNOWN objects and the list of pairs";
  ros_time_ = ros::Time(52.5);
  EXPECT_EQ(stepAfter(2000),
            (Lines{"forget all: no new mesh",
                   "heartbeat 52.5: cloth(newest mesh is 2.500 s old) cable(no mesh yet)"}));
}

// ROS time may stand still meanwhile.
TEST_F(MeshesTest, AHeartbeatSaysThatItFoundNoNewMesh) {
  give(0, 50);
  step();
  EXPECT_EQ(stepAfter(1000), (Lines{"forget all: no new mesh",
                                    "heartbeat 50: cloth(no new mesh) cable(no mesh yet)"}));
}

TEST_F(MeshesTest, ADetectorThatThrowsCostsOneCycle) {
  detector_.failure = "out of memory";
  give(0, 50);
  give(1, 50);
  EXPECT_EQ(step(), (Lines{"error: out of memory", "no result 50: *cloth@50 *cable@50"}));
  detector_.failure.clear();
  give(0, 50.25);
  EXPECT_EQ(step(), Lines{"cycle 50.25: *cloth@50.25 cable@50"});
}

TEST_F(MeshesTest, WhereNothingIsToBeLookedAtNoDetectorRuns) {
  detector_.failure = "it ran";
  give(0, 50);
  EXPECT_EQ(step(), Lines{"cycle 50: *cloth@50 cable(no mesh yet)"});
}

TEST_F(MeshesTest, EachCycleSearchesTheNearestPairsAndListsNearOnesOnRequest) {
  give(0, 50);
  give(1, 50);
  step();
  EXPECT_TRUE(detector_.options.nearest);
  EXPECT_FALSE(detector_.options.near_pairs);
}

TEST_F(MeshesTest, GeometryIsComputedWhileSomebodyWantsIt) {
  give(0, 50);
  give(1, 50);
  step();
  EXPECT_FALSE(detector_.options.geometry);
  said_.wants_geometry = true;
  give(0, 50.1);
  stepAfter(100);
  EXPECT_TRUE(detector_.options.geometry);
  said_.wants_geometry = false;
  give(0, 50.2);
  stepAfter(100);
  EXPECT_FALSE(detector_.options.geometry);
}

// The cloth is a small triangle, the cable a tetrahedron around it.
TEST_F(MeshesTest, WhatIsWithinIsLookedForIfAskedFor) {
  const auto giveBoth = [this](double stamp_s) {
    auto around = boost::make_shared<DeformableMesh>();
    around->header.stamp = ros::Time(stamp_s);
    around->header.frame_id = "base";
    around->topology_id = 4;
    around->vertices = {-9, -9, -9, 50, -9, -9, -9, 50, -9, -9, -9, 50};
    around->triangles = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    meshes()[1].store({around});
    give(0, stamp_s);
  };
  parameters_.containment = true;
  parameters_.max_cycle_s = 600;
  steady_time_ = std::chrono::steady_clock::now();  // the deadline is looked at by the real clock
  giveBoth(50);
  step();
  ASSERT_EQ(said_.inside.size(), 1U);
  EXPECT_EQ(said_.inside[0].inner, 0U);
  EXPECT_EQ(said_.inside[0].outer, 1U);
  EXPECT_EQ(said_.looks_within, 1);
  detector_.out_of_time = true;  // contacts are missing, so nothing is wholly within
  giveBoth(50.1);
  stepAfter(100);
  EXPECT_EQ(said_.looks_within, 1);
  detector_.distances.resize(1);  // but what is apart is known
  giveBoth(50.2);
  stepAfter(100);
  EXPECT_EQ(said_.looks_within, 2);
}

TEST_F(MeshesTest, WhatIsWithinIsNotLookedForOtherwise) {
  give(0, 50);
  give(1, 50);
  step();
  EXPECT_EQ(said_.looks_within, 0);
}

TEST_F(MeshesTest, AStepThatFailsIsTriedAgainInASecond) {
  robot_source_ = []() -> std::shared_ptr<const RobotGeometry> { throw std::bad_alloc(); };
  give(0, 50);
  EXPECT_EQ(step(), Lines{"error: std::bad_alloc"});
  EXPECT_EQ(sleepMs(), 1000);
  robot_source_ = nullptr;
  EXPECT_EQ(step(), Lines{"cycle 50: *cloth@50 cable(no mesh yet)"}) << "or when something comes";
}

// Does what the monitor's threads do, so that ThreadSanitizer can find a race.
TEST_F(MeshesTest, MeshesAndRequestsComeFromOtherThreads) {
  meshes();  // made before there are threads
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
    requests_.changeAllowedContacts({});
    requests_.attach("cloth", {});
    requests_.change(startValues(parameters_));
  }
  publisher.join();
  while (meshes()[0].hasWaiting()) std::this_thread::yield();
  requests_.stop();
  detection.join();
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(std::count(said.begin(), said.end(), "cycle 49.75: *cloth@49.75 cable(no mesh yet)"),
            1);
}

}  // namespace
}  // namespace deformable_contact_monitor
