// Checks that an evaluation knows no transform and no mesh that was recorded later, except where
// there is no earlier value, and that it follows the clocks of a recording.
#include <deformable_contact_monitor/DeformableMesh.h>
#include <gtest/gtest.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "test_data.h"
#include "written_bag.h"

namespace deformable_contact_monitor {
namespace {

TEST(RecordedTime, AStaticTransformHoldsFromItsRecordingOn) {
  WrittenBag bag;
  bag.camera(0, 1);
  bag.meshes(1, 5);
  bag.camera(kPeriod * 6, 0);
  bag.meshes(6, 5);
  bag.camera(kPeriod * 11, 1);
  bag.camera(kPeriod * 11.01, 1);
  bag.meshes(11, 5);
  EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)), "-----CCCCC-----");
}

// The node does the same: many publishers delete a marker before they draw it anew.
std::string statesOfMarkers(MeshType type, void (WrittenBag::*add)(double, std::int32_t)) {
  using visualization_msgs::Marker;
  WrittenBag bag;
  bag.camera(0, 0);
  for (const int i : {1, 2, 3, 4, 8, 9}) {
    bag.finger(kPeriod * i);
    for (const std::int32_t deletion : {Marker::DELETEALL, Marker::DELETE}) {
      if (i != 1 && i != 8) (bag.*add)(kPeriod * i - 0.0625, deletion);
    }
    (bag.*add)(kPeriod * i, Marker::ADD);
  }
  (bag.*add)(kPeriod * 6, Marker::DELETE);  // 0.25 s before the next marker
  bag.add("/cloth", at(kPeriod * 6.5), visualization_msgs::MarkerArray());  // in no way a mesh
  MonitorParameters configured;
  configured.objects.resize(1);
  configured.objects[0].name = "cloth";
  configured.objects[0].topic = "/cloth";
  configured.objects[0].type = type;
  configured.objects[0].marker.second = 2;
  BagFiles files;
  files.reference_frame = "base_link";
  bag.links(0, 0);
  files.bags = {bag.finish()};
  return evaluate(files, configured).states["cloth"];
}

TEST(RecordedTime, ADeletedMarkerKeepsItsMeshForAMoment) {
  EXPECT_EQ(statesOfMarkers(MeshType::kMarker, &WrittenBag::marker), "CCCC?CC");
  EXPECT_EQ(statesOfMarkers(MeshType::kMarkerArray, &WrittenBag::markerArray), "CCCC?CC");
}

TEST(RecordedTime, OnlyTheFirstStaticTransformHoldsBefore) {
  WrittenBag bag;
  bag.meshes(1, 5);
  bag.camera(kPeriod * 6, 0);
  bag.meshes(6, 5);
  bag.camera(kPeriod * 11, 1);
  bag.meshes(11, 5);
  EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)), "CCCCCCCCCC-----");
}

// A recorder may start before the clock does, and latched messages come first. rosbag writes no
// earlier time than this one.
TEST(RecordedTime, WhatWasRecordedAtTimeZeroHolds) {
  WrittenBag bag;
  bag.transform("/tf_static", ros::Time(0, 1), ros::Time(), "camera", 0);
  bag.meshes(1, 5);
  bag.camera(kPeriod * 6, 1);
  bag.meshes(6, 5);
  EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)), "CCCCC-----");
}

// The node gets a mesh with what was sent before it, however old its stamp is.
TEST(RecordedTime, TheTimeOfRecordingCountsAndNotTheStamp) {
  WrittenBag bag;
  bag.camera(0, 1);
  for (int i = 1; i <= 9; ++i) bag.finger(kPeriod * i);
  bag.mesh(at(1.2), at(kPeriod * 2), "quick");
  bag.mesh(at(1.3), at(kPeriod * 4), "quick");
  bag.camera(1.5, 0);
  bag.mesh(at(1.7), at(kPeriod * 3), "slow");
  bag.mesh(at(1.8), at(kPeriod * 5), "slow");
  Found found = evaluate(&bag, urdf("prismatic", 0.1));
  EXPECT_EQ(found.states["quick"], "--");
  EXPECT_EQ(found.states["slow"], "CC");
}

// The node runs a cycle when its transforms are there, with what is static then.
TEST(RecordedTime, ACycleThatWaitsForTransformsKnowsWhatComesMeanwhile) {
  for (const double timeout_s : {0.05, 0.2}) {
    WrittenBag bag;
    bag.camera(0, 1);
    for (int i = 1; i <= 6; ++i) {
      const ros::Time stamp = at(kPeriod * i);
      bag.mesh(stamp + ros::Duration(0.01), stamp, "cloth");
      if (i == 4) bag.camera(kPeriod * i + 0.08, 0);
      bag.transform("/tf", stamp + ros::Duration(0.1), stamp, "finger", 0);
    }
    MonitorParameters parameters;
    parameters.reference_frame = "base_link";
    parameters.tf_timeout_s = timeout_s;
    EXPECT_EQ(evaluate(&bag, urdf("prismatic", 0.1), parameters).states["cloth"],
              timeout_s > 0.1 ? "---CCC" : "----CC");
  }
}

// Where the finger was for a second, no transform tells.
TEST(RecordedTime, NothingIsKnownWithinAnOutageOfTransforms) {
  WrittenBag bag;
  bag.camera(0, 0);
  for (int i = 1; i <= 15; ++i) {
    if (i <= 3 || i >= 12) bag.finger(kPeriod * i);
    bag.mesh(at(kPeriod * i + 0.01), at(kPeriod * i), "cloth");
  }
  EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)), "CCC????????CCCC");
}

// Such transforms are used, but the node would not have waited for them.
TEST(RecordedTime, CyclesWithTransformsAfterTheTimeoutAreCounted) {
  for (const double timeout_s : {0.05, 0.2}) {
    WrittenBag bag;
    bag.camera(0, 0);
    for (int i = 1; i <= 9; ++i) {
      const ros::Time stamp = at(kPeriod * i);
      // Of the third, there is no transform, and one follows after half a second.
      if (i > 3 && i < 7) continue;
      bag.transform("/tf", stamp + ros::Duration(0.1), stamp, "finger", 0);
    }
    for (int i = 1; i <= 8; ++i) {
      const double late_s = i == 8 ? 0.11 : 0.01;  // the last mesh comes after its transform
      bag.mesh(at(kPeriod * i + late_s), at(kPeriod * i), "cloth");
    }
    MonitorParameters parameters;
    parameters.reference_frame = "base_link";
    parameters.tf_timeout_s = timeout_s;
    const Found found = evaluate(&bag, urdf("prismatic", 0.1), parameters);
    EXPECT_EQ(found.states.at("cloth"), times(8, 'C'));
    // Before the first transform, the node does not know that there is a frame to wait for.
    EXPECT_EQ(found.late_cycles, timeout_s < 0.1 ? 6U : 3U);
  }
}

TEST(RecordedTime, TransformsThatNobodyCanUseAreCounted) {
  WrittenBag bag;
  bag.camera(0, std::nan(""));
  bag.camera(0.01, 0);
  bag.meshes(1, 3);
  bag.finger(kPeriod * 3);  // tf2 has it already
  bag.transform("/tf", at(kPeriod * 3.5), at(kPeriod * 3.5), "finger", std::nan(""));
  bag.transform("/tf", at(kPeriod * 3.5), at(999), "finger", 0);
  bag.meshes(4, 3);
  const Found found = evaluate(&bag, urdf("prismatic", 0.1));
  EXPECT_EQ(found.states.at("cloth"), times(6, 'C'));
  EXPECT_EQ(found.bad_transforms, 3U);
}

// Otherwise each of its meshes would have two cycles.
TEST(RecordedTime, ABagIsReadOnce) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.links(0, 0);
  bag.meshes(1, 5);
  BagFiles files;
  files.reference_frame = "base_link";
  const std::string path = bag.finish(), copy = path + ".copy.bag", link = path + ".link.bag";
  std::filesystem::copy_file(path, copy);
  std::filesystem::create_symlink(path, link);
  for (const std::string& same : {path, link}) {
    files.bags = {path, same};
    try {
      evaluate(files);
      ADD_FAILURE() << same;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).find(same + ": is given twice"), 0U) << error.what();
    }
  }
  files.bags = {path, copy};
  const std::vector<std::string> warnings = evaluate(files).warnings;
  EXPECT_EQ(
      std::count_if(warnings.begin(), warnings.end(),
                    [](const auto& line) { return line.find("5 meshes are in two bags") == 0; }),
      1);
  std::filesystem::remove(copy);
  std::filesystem::remove(link);
}

// Meshes of one stamp share a cycle only if the node would have known the same for both.
TEST(RecordedTime, MeshesOfOneStampThatKnowDifferentThings) {
  WrittenBag bag;
  bag.camera(0, 1);
  bag.finger(1);
  bag.mesh(at(1.1), at(1), "quick");
  bag.camera(1.2, 0);
  bag.mesh(at(1.3), at(1), "slow");
  Found found = evaluate(&bag, urdf("prismatic", 0.1));
  EXPECT_EQ(found.states["quick"], "-");
  EXPECT_EQ(found.states["slow"], "C");
}

// The cloth is stamped two periods late, so it is posed with the finger of then.
TEST(RecordedTime, LateStampsAreCorrected) {
  for (const double offset_s : {0.0, -2 * kPeriod}) {
    WrittenBag bag;
    bag.camera(0, 0);
    for (int i = 1; i <= 12; ++i) {
      bag.transform("/tf", at(kPeriod * i), at(kPeriod * i), "finger", i == 5 ? 0 : 3);
      if (i > 3) bag.mesh(at(kPeriod * i + kDelay), at(kPeriod * i), "cloth");
    }
    bag.links(0, 0);
    MonitorParameters configured;
    configured.objects.resize(1);
    configured.objects[0].name = "cloth";
    configured.objects[0].topic = "/cloth";
    configured.objects[0].stamp_offset_s = offset_s;
    BagFiles files;
    files.reference_frame = "base_link";
    files.bags = {bag.finish()};
    const Found found = evaluate(files, configured);
    EXPECT_EQ(found.states.at("cloth"), offset_s < 0 ? "---C-----" : "-C-------");
    EXPECT_EQ(found.stamps.front(), at(4 * kPeriod + offset_s));
  }
}

// tf2 keeps to the topic that was first, and a node that starts later to the other one.
TEST(RecordedTime, AFrameThatIsOnBothTopicsIsNotKnown) {
  WrittenBag fixed;
  fixed.camera(0, 1);
  fixed.meshes(1, 3);
  fixed.transform("/tf", at(kPeriod * 4), at(kPeriod * 4), "camera", 0);
  fixed.meshes(4, 6);
  EXPECT_EQ(statesOf(&fixed, urdf("prismatic", 0.1)), "---??????");

  WrittenBag moving;
  for (int i = 0; i < 10; ++i) {
    moving.transform("/tf", at(kPeriod * i), at(kPeriod * i), "camera", i < 5 ? 1 : 0);
    if (i == 7) moving.camera(kPeriod * 7.5, 1);
    moving.meshes(i, 1);
  }
  EXPECT_EQ(statesOf(&moving, urdf("prismatic", 0.1)), "-----CC???");

  WrittenBag same;  // /tf says what /tf_static says, also after that has changed
  same.camera(0, 1);
  for (int i = 1; i < 10; ++i) {
    if (i == 5) same.camera(kPeriod * 4.5, 0);
    same.transform("/tf", at(kPeriod * i), at(kPeriod * i), "camera", i < 5 ? 1 : 0);
    same.meshes(i, 1);
  }
  EXPECT_EQ(statesOf(&same, urdf("prismatic", 0.1)), "----CCCCC");
}

// Nobody knows whether the first one was still there.
TEST(RecordedTime, AStaticFrameThatTwoNodesPutElsewhereIsNotKnown) {
  for (const std::string second : {"/urdf", "/calibration"}) {
    WrittenBag bag;
    bag.camera(0, 0, "/urdf");
    bag.meshes(1, 2);
    bag.camera(kPeriod * 2.5, 0, "/copy");
    bag.meshes(3, 2);
    bag.camera(kPeriod * 4.5, 1, second);
    bag.camera(kPeriod * 4.6, 0, "/urdf");  // before the next mesh
    bag.meshes(5, 2);
    EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)), second == "/urdf" ? "CCCCCC" : "CCCC??")
        << second;
  }
}

// The second episode ends before its first mesh, so that no mesh tells of it. It may begin as the
// first one did. Of two recordings that were merged, the second one has the same transforms, or
// those of another frame, and each may lack some.
TEST(RecordedTime, TransformsAloneTellThatASimulatorStartedAnew) {
  enum class Second { kEpisode, kLateEpisode, kSame, kOtherFrame };
  for (const Second second :
       {Second::kEpisode, Second::kLateEpisode, Second::kSame, Second::kOtherFrame}) {
    SCOPED_TRACE(static_cast<int>(second));
    WrittenBag bag;
    bag.camera(0, 0);
    const bool is_other = second == Second::kOtherFrame;
    const bool is_episode = second == Second::kEpisode || second == Second::kLateEpisode;
    for (int i = 0; i < 80; ++i) {
      const ros::Time stamp = at(kPeriod * (i + 0.25));
      if (is_episode || i % 3 != 0) {
        bag.transform("/tf", stamp, stamp, is_other ? "elsewhere" : "finger", 0);
        bag.transform("/tf", stamp, stamp, "broken", std::nan(""));
      }
      if (i > 40) bag.mesh(at(kPeriod * (i + 0.3)), at(kPeriod * i), "cloth");
    }
    for (int i = 0; i < (is_episode ? 70 : 80); ++i) {
      const double shift = second == Second::kEpisode ? 0.75 : 0.25;
      const ros::Time stamp = at(kPeriod * (i + shift));
      const bool is_away = is_episode && i >= (second == Second::kLateEpisode ? 45 : 0);
      if (is_other || is_episode || i % 3 != 1) {
        bag.transform("/tf", stamp, stamp, "finger", is_away ? 5 : 0);
        bag.transform("/tf", stamp, stamp, "broken", std::nan(""));
      }
    }
    EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)), times(39, 'C'));
  }
}

TEST(RecordedTime, AStaticTransformThatTf2RefusesChangesNothing) {
  WrittenBag bag;
  bag.camera(0, std::nan(""));
  bag.camera(0.01, 0);
  bag.meshes(1, 3);
  bag.camera(kPeriod * 4, std::nan(""));
  bag.meshes(4, 3);
  EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)), "CCCCCC");
}

// A simulator starts anew while a recorder with a clock of its own goes on. Each pass is judged by
// its own transforms, whose stamps are the same.
TEST(RecordedTime, AClockThatGoesBackStartsAnew) {
  WrittenBag bag;
  bag.camera(0, 0);
  for (int pass = 0; pass < 2; ++pass) {
    for (int i = 1; i <= 40; ++i) {
      const ros::Time stamp(10 + kPeriod * i), received = at(20 * pass + kPeriod * i);
      bag.transform("/tf", received, stamp, "finger", pass);
      bag.mesh(received + ros::Duration(0.02), stamp, "cloth");
    }
  }
  Found found = evaluate(&bag, urdf("prismatic", 0.1));
  EXPECT_EQ(found.states["cloth"], times(40, 'C') + times(40, '-'));
  ASSERT_EQ(found.stamps.size(), 80U);
  EXPECT_EQ(found.stamps[0], found.stamps[40]);
  ASSERT_EQ(found.events.size(), 2U);
  EXPECT_EQ(found.events[1].reason.find("time jump: the clock went back by "), 0U);
}

// A simulator that starts anew counts topology_id anew, and may send its triangles late.
TEST(RecordedTime, TheTrianglesOfAnEpisodeAreItsOwn) {
  constexpr int kCount = 40, kSends = 8;  // every so many meshes have triangles
  for (const int first : {0, 7}) {
    WrittenBag bag;
    bag.camera(0, 0);
    for (int episode = 0; episode < 2; ++episode) {
      for (int i = 0; i < kCount; ++i) {
        const ros::Time stamp(10 + kPeriod * i), received = at(20 * episode + kPeriod * i);
        bag.transform("/tf", received, stamp, "finger", 0);
        DeformableMesh mesh;
        mesh.header.stamp = stamp + ros::Duration(0.01 * (1 - episode));
        mesh.header.frame_id = "camera";
        mesh.object = "cloth";
        mesh.topology_id = 1;
        mesh.vertices = {0, 0, 0, 0.2F, 0, 0, 0, 0.2F, 0, 5, 5, 5, 5, 6, 5, 6, 5, 5};
        if (i % kSends == (episode == 0 ? first : 7)) mesh.triangles = {3, 4, 5};
        if (episode == 1 && !mesh.triangles.empty()) mesh.triangles = {0, 1, 2};
        bag.add("/cloth", received + ros::Duration(0.02), mesh);
      }
    }
    // Only the triangle of the second episode touches. Nothing is known after the last transform.
    EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)),
              times(kCount - 1, '-') + "?" + times(kCount, 'C'))
        << first;
  }
}

// Episodes of a simulator, each as short as `episode_s`. The finger touches in the second one.
std::string statesOfEpisodes(double episode_s, bool recorder_restarts, double mesh_late_s = 0.01) {
  constexpr int kEpisodes = 4;
  const int count = static_cast<int>(episode_s / kPeriod);
  WrittenBag bag;
  bag.camera(0, 0);
  for (int episode = 0; episode < kEpisodes; ++episode) {
    for (int i = 1; i <= count; ++i) {
      const ros::Time stamp(1000 + kPeriod * i);
      const ros::Time received = recorder_restarts ? stamp : at(kPeriod * (i + episode * count));
      bag.transform("/tf", received, stamp, "finger", episode == 1 ? 0 : 1);
      bag.mesh(received + ros::Duration(mesh_late_s), stamp, "cloth");
    }
  }
  return statesOf(&bag, urdf("prismatic", 0.1));
}

// The last message of an episode is a mesh or a transform.
TEST(RecordedTime, ShortEpisodesAreApart) {
  for (const double episode_s : {0.75, 2.0, 3.0, 3.5, 5.0}) {
    const int count = static_cast<int>(episode_s / kPeriod);
    for (const bool recorder_restarts : {false, true}) {
      for (const double mesh_late_s : {0.01, -0.01}) {
        EXPECT_EQ(statesOfEpisodes(episode_s, recorder_restarts, mesh_late_s),
                  times(count, '-') + times(count, 'C') + times(2 * count, '-'))
            << episode_s << recorder_restarts << mesh_late_s;
      }
    }
  }
}

// A recorder's simulated time has steps, and is still that of before for the first messages.
TEST(RecordedTime, ARecorderWhoseClockGoesBackLate) {
  constexpr int kCount = 24;
  WrittenBag bag;
  bag.camera(0, 0);
  ros::Time received;
  for (int episode = 0; episode < 3; ++episode) {
    for (int i = 1; i <= kCount; ++i) {
      const ros::Time stamp(1000 + kPeriod * i);
      if (episode == 0 || i > 1) received = ros::Time(1000 + 2 * kPeriod * (i / 2));
      bag.transform("/tf", received, stamp, "finger", episode == 1 ? 0 : 1);
      bag.mesh(received, stamp, "cloth");
    }
  }
  EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)),
            times(kCount, '-') + times(kCount, 'C') + times(kCount, '-'));
}

// What is recorded after the clock went back, and was sent before, belongs to what it was sent
// with.
TEST(RecordedTime, MeshesThatAreLateInTheirEpisode) {
  for (const double late_s : {0.3, 0.6}) {
    EXPECT_EQ(statesOfEpisodes(3, false, late_s), times(24, '-') + times(24, 'C') + times(48, '-'))
        << late_s;
  }
}

// The last episode is too short to be certain after a second.
TEST(RecordedTime, TheClockGoesBackShortlyBeforeTheEnd) {
  WrittenBag bag;
  bag.camera(0, 0);
  for (int i = 1; i <= 30; ++i) {
    const double back_s = i > 24 ? 30 : 0;
    bag.transform("/tf", at(kPeriod * i), at(kPeriod * i - back_s), "finger", i > 24 ? 1 : 0);
    bag.mesh(at(kPeriod * i + 0.01), at(kPeriod * i - back_s), "cloth");
  }
  EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)), times(24, 'C') + times(6, '-'));
}

// A publisher that is late for longer than it is certain is none whose clock went back.
TEST(RecordedTime, ALateSourceIsNoJump) {
  WrittenBag bag;
  bag.camera(0, 0);
  for (int i = 1; i <= 60; ++i) {
    const double late_s = i > 20 && i <= 40 ? 0.6 : 0;
    bag.finger(kPeriod * i);
    bag.transform("/tf", at(kPeriod * i + 0.001), at(kPeriod * i - late_s), "other_frame", 0);
    bag.mesh(at(kPeriod * i + 0.01), at(kPeriod * i), "cloth");
  }
  const Found found = evaluate(&bag, urdf("prismatic", 0.1));
  EXPECT_EQ(found.states.at("cloth"), times(60, 'C'));
  EXPECT_EQ(found.events.size(), 1U);
}

// Some stamps are of another clock. They cost nobody else anything.
TEST(RecordedTime, AFewWrongStampsCostNoOtherCycle) {
  for (const double wrong : {0.5, 1.0, 999.0, 1040.0, 5000.0, 4e9}) {
    WrittenBag bag;
    bag.camera(0, 0);
    bag.meshes(1, 20);
    bag.transform("/tf", at(kPeriod * 20.5), ros::Time(wrong), "finger", 5);
    bag.mesh(at(kPeriod * 20.6), ros::Time(wrong), "other");
    bag.meshes(21, 60);
    EXPECT_EQ(evaluate(&bag, urdf("prismatic", 0.1)).states["cloth"], times(80, 'C')) << wrong;
  }
}

// Most stamps are ahead where the recorder's clock is behind.
TEST(RecordedTime, ARecorderWhoseClockIsBehind) {
  WrittenBag bag;
  bag.camera(0, 0);
  for (int i = 1; i <= 10; ++i) {
    bag.transform("/tf", at(kPeriod * i), at(3600 + kPeriod * i), "finger", 0);
    bag.mesh(at(kPeriod * i), at(3600 + kPeriod * i), "cloth");
  }
  EXPECT_EQ(statesOf(&bag, urdf("prismatic", 0.1)), times(10, 'C'));
}

// Two of the inputs that people reported; tool_change has no URDF.
TEST(RecordedTime, TheFieldsBags) {
  DCM_REQUIRE_TEST_DATA();
  const std::string folder = "field/bags/";
  BagFiles files;
  files.bags = {testDataFile(folder + "static_twice.bag")};
  files.robot_description = testDataFile(folder + "finger.urdf");
  EXPECT_EQ(evaluate(files).states["cloth"], times(50, '-') + times(50, 'C'));
  files.bags = {testDataFile(folder + "tool_change.bag")};
  files.robot_description.clear();
  files.reference_frame = "base_link";
  EXPECT_EQ(evaluate(files).states["cloth"], times(50, '-') + times(50, 'C'));
}

}  // namespace
}  // namespace deformable_contact_monitor
