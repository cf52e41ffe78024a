// Checks that an evaluation knows nothing that was recorded later, except where there is no earlier
// value. The scene is a finger, a box of 0.1 m around the origin, and one triangle through
// it that a camera sees.
#include <console_bridge/console.h>
#include <deformable_contact_monitor/DeformableMesh.h>
#include <deformable_contact_monitor/LinkMeshes.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>
#include <unistd.h>
#include <visualization_msgs/Marker.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "test_data.h"
#include "tools/bags/bag_cycles.h"
#include "tools/bags/bag_setup.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kStart = 1000;
constexpr double kPeriod = 0.125;   // of the meshes
constexpr double kDelay = 0.03125;  // from a mesh's stamp to its recording

ros::Time at(double s) { return ros::Time(kStart + s); }

// A bag that exists as long as this.
class WrittenBag {
 public:
  WrittenBag() {
    close(mkstemps(path_, 4));
    bag_.open(path_, rosbag::bagmode::Write);
  }
  WrittenBag(const WrittenBag&) = delete;
  WrittenBag& operator=(const WrittenBag&) = delete;
  ~WrittenBag() { std::remove(path_); }

  template <typename M>
  void add(const std::string& topic, const ros::Time& received, const M& message) {
    bag_.write(topic, received, message);
  }
  // Adds a transform that moves by z [m]. Of a static one the stamp has no meaning.
  void transform(const std::string& topic, const ros::Time& received, const ros::Time& stamp,
                 const std::string& frame, double z) {
    tf2_msgs::TFMessage message;
    message.transforms.resize(1);
    geometry_msgs::TransformStamped& transform = message.transforms[0];
    transform.header.stamp = stamp;
    transform.header.frame_id = "base_link";
    transform.child_frame_id = frame;
    transform.transform.translation.z = z;
    transform.transform.rotation.w = 1;
    add(topic, received, message);
  }
  void camera(double s, double z) { transform("/tf_static", at(s), at(s), "camera", z); }
  // The finger at the origin.
  void finger(double s) { transform("/tf", at(s), at(s), "finger", 0); }
  void mesh(const ros::Time& received, const ros::Time& stamp, const std::string& object) {
    DeformableMesh mesh;
    mesh.header.stamp = stamp;
    mesh.header.frame_id = "camera";
    mesh.object = object;
    mesh.vertices = {0, 0, 0, 0.2F, 0, 0, 0, 0.2F, 0};
    mesh.triangles = {0, 1, 2};
    add("/" + object, received, mesh);
  }
  // Adds a marker of the same triangle, or the message that deletes it.
  void marker(double s, std::int32_t action) {
    visualization_msgs::Marker marker;
    marker.action = action;
    marker.type = visualization_msgs::Marker::TRIANGLE_LIST;
    marker.header.frame_id = "camera";
    if (action == visualization_msgs::Marker::ADD) marker.header.stamp = at(s);
    marker.scale.x = marker.scale.y = marker.scale.z = marker.pose.orientation.w = 1;
    marker.points.resize(3);
    marker.points[1].x = marker.points[2].y = 0.2;
    add("/cloth", at(s + kDelay), marker);
  }
  // Adds meshes with the finger's transforms at `count` stamps, from `first` times the period on.
  void meshes(int first, int count) {
    for (int i = first; i < first + count; ++i) {
      finger(kPeriod * i);
      mesh(at(kPeriod * i + kDelay), at(kPeriod * i), "cloth");
    }
  }
  // Adds link meshes: the finger as one triangle at height z [m], and other links beside it.
  void links(double s, double z, const std::string& more = "") {
    LinkMeshes message;
    message.header.stamp = at(s);
    for (const std::string& name : {std::string("finger"), more}) {
      if (name.empty()) continue;
      LinkMesh link;
      link.link = name;
      const float h = static_cast<float>(z);
      link.vertices = {0.05F, 0.05F, h - 1, 0.05F, 0.05F, h + 1, 0.05F, 0.06F, h};
      link.triangles = {0, 1, 2};
      message.meshes.push_back(link);
    }
    add("/contact_monitor/robot_meshes", at(s), message);
  }
  void text(double s, const std::string& topic, const std::string& data) {
    std_msgs::String message;
    message.data = data;
    add(topic, at(s), message);
  }

  std::string finish() {
    bag_.close();
    return path_;
  }

 private:
  char path_[32] = "/tmp/recorded_time_XXXXXX.bag";
  rosbag::Bag bag_;
};

// A robot whose finger is a box of 0.1 m, and slides along z or stands at `z` [m].
std::string urdf(const std::string& joint_type, double size, double z = 0) {
  const std::string side = std::to_string(size);
  return "<robot name='r'><link name='base_link'/><link name='finger'><collision><geometry><box "
         "size='" +
         side + " " + side + " " + side +
         "'/></geometry></collision></link><joint name='j' type='" + joint_type +
         "'><origin xyz='0 0 " + std::to_string(z) +
         "'/><parent link='base_link'/><child link='finger'/><axis xyz='0 0 1'/><limit lower='-9' "
         "upper='9' effort='1' velocity='1'/></joint></robot>";
}

// The states of the finger and an object stand in the order of the object's cycles: "C" is CONTACT,
// "-" NONE, "?" UNKNOWN.
struct Found {
  std::map<std::string, std::string> states;  // by object
  std::vector<ros::Time> stamps;              // of all cycles
  std::vector<ContactEvent> events;
  std::vector<std::string> warnings;
};

Found evaluate(const BagFiles& files, const MonitorParameters& configured = MonitorParameters()) {
  ros::Time::init();
  console_bridge::noOutputHandler();  // tf2 prints a line for each bad transform
  Found found;
  const auto warn = [&](const std::string& what) { found.warnings.push_back(what); };
  BagReader reader(files.bags, neededMessages(configured, files));
  BagContents contents =
      scanBags(&reader, files, configured.pair_classes.needRobot(), [](std::uint64_t) {});
  const BagSetup setup = setUpBags(files, configured, SceneObject(), &contents, warn);
  EvaluationRun run("cpu", std::make_unique<DetectedContacts>(makeCpuDetector()), Options(),
                    stateRules(setup.parameters), {});
  BagCycles cycles(setup.parameters, contents, setup.robots, nullptr);
  cycles.run(&reader, [&](CycleReport* cycle) {
    if (!cycles.forgets().empty()) run.forget(cycles.forgets(), cycle->header.stamp);
    found.stamps.push_back(cycle->header.stamp);
    run.evaluate(cycle, &cycles.sceneOfStep());
    for (const ContactEvent& event : run.steps.events()) found.events.push_back(event);
    for (std::size_t i = 0; i < cycle->pairs.size(); ++i) {
      const ContactState& state = run.states.states.at(i);
      if (!isOfCycle(cycle->bodies, cycle->pairs[i]) || state.body_a != "finger") continue;
      found.states[state.body_b] += std::string("-nC!?P").at(state.state);
    }
  });
  return found;
}

// Evaluates a bag with a URDF that is given beside it, or with what is in the bag.
Found evaluate(WrittenBag* bag, const std::string& urdf_xml = "",
               const MonitorParameters& parameters = MonitorParameters()) {
  BagFiles files;
  files.bags = {bag->finish()};
  files.reference_frame = "base_link";
  char path[] = "/tmp/recorded_time_XXXXXX.urdf";
  if (!urdf_xml.empty()) {
    close(mkstemps(path, 5));
    FILE* const file = std::fopen(path, "w");
    std::fputs(urdf_xml.c_str(), file);
    std::fclose(file);
    files.robot_description = path;
  }
  Found found = evaluate(files, parameters);
  if (!urdf_xml.empty()) std::remove(path);
  return found;
}

std::string statesOf(WrittenBag* bag, const std::string& urdf_xml = "") {
  return evaluate(bag, urdf_xml).states["cloth"];
}

std::string times(int count, char state) {
  return std::string(static_cast<std::size_t>(count), state);
}

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
TEST(RecordedTime, ADeletedMarkerKeepsItsMeshForAMoment) {
  using visualization_msgs::Marker;
  WrittenBag bag;
  bag.camera(0, 0);
  for (const int i : {1, 2, 3, 4, 8, 9}) {
    bag.finger(kPeriod * i);
    for (const std::int32_t deletion : {Marker::DELETEALL, Marker::DELETE}) {
      if (i != 1 && i != 8) bag.marker(kPeriod * i - 0.0625, deletion);
    }
    bag.marker(kPeriod * i, Marker::ADD);
  }
  bag.marker(kPeriod * 6, Marker::DELETE);  // 0.25 s before the next marker
  MonitorParameters configured;
  configured.objects.resize(1);
  configured.objects[0].name = "cloth";
  configured.objects[0].topic = "/cloth";
  configured.objects[0].type = MeshType::kMarker;
  BagFiles files;
  files.reference_frame = "base_link";
  bag.links(0, 0);
  files.bags = {bag.finish()};
  EXPECT_EQ(evaluate(files, configured).states["cloth"], "CCCC?CC");
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

// tf2 decides by a frame's first transform whether it is static.
TEST(RecordedTime, AStaticFrameThatAlsoMovesIsAsInTf2) {
  WrittenBag fixed;
  fixed.camera(0, 1);
  fixed.meshes(1, 3);
  fixed.transform("/tf", at(kPeriod * 4), at(kPeriod * 9), "camera", 0);
  fixed.meshes(4, 6);
  EXPECT_EQ(statesOf(&fixed, urdf("prismatic", 0.1)), "---CCCCCC");

  WrittenBag moving;
  for (int i = 0; i < 10; ++i) {
    moving.transform("/tf", at(kPeriod * i), at(kPeriod * i), "camera", i < 5 ? 1 : 0);
    if (i == 7) moving.camera(kPeriod * 7.5, 1);
    moving.meshes(i, 1);
  }
  EXPECT_EQ(statesOf(&moving, urdf("prismatic", 0.1)), "-----CCCCC");
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

TEST(RecordedTime, LinkMeshesHoldFromTheirRecordingOn) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.meshes(1, 2);
  bag.links(kPeriod * 3, 5);
  bag.meshes(3, 3);
  bag.links(kPeriod * 6, 0, "tool");
  bag.meshes(6, 3);
  bag.links(kPeriod * 9, 0, "tool");
  bag.meshes(9, 3);
  Found found = evaluate(&bag);
  EXPECT_EQ(found.states["cloth"], "-----CCCCCC");
  ASSERT_EQ(found.events.size(), 1U) << "the same robot again is no other robot";
  EXPECT_EQ(found.events[0].type, ContactEvent::BEGIN);
}

// Another robot ends what is known of the earlier one, as in the node.
TEST(RecordedTime, AnotherRobotEndsContacts) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.links(0, 0);
  bag.meshes(1, 3);
  bag.links(kPeriod * 4, 5);
  bag.meshes(4, 1);
  const Found found = evaluate(&bag);
  ASSERT_EQ(found.events.size(), 2U);
  EXPECT_EQ(found.events[1].type, ContactEvent::END);
  EXPECT_EQ(found.events[1].reason, "robot changed");
}

TEST(RecordedTime, LinkMeshesThatCannotBeUsedLeaveTheRobotAsItWas) {
  WrittenBag bag;
  bag.camera(0, 0);
  bag.links(0, 0);
  bag.meshes(1, 3);
  bag.links(kPeriod * 4, 5, "finger");
  bag.meshes(4, 3);
  Found found = evaluate(&bag);
  EXPECT_EQ(found.states["cloth"], "CCCCCC");
  ASSERT_EQ(found.warnings.size(), 1U);
  EXPECT_NE(found.warnings[0].find("'finger' was sent twice"), std::string::npos);
}

TEST(RecordedTime, ARobotDescriptionHoldsFromItsRecordingOn) {
  WrittenBag bag;
  bag.camera(0, 0.05);
  bag.text(0, "/robot_description", urdf("prismatic", 0.05));
  bag.meshes(1, 3);
  bag.text(kPeriod * 4, "/robot_description", urdf("prismatic", 0.2));
  bag.meshes(4, 3);
  EXPECT_EQ(statesOf(&bag), "---CCC");
}

// Without TF, the URDF of that time poses the links, fixed ones too.
TEST(RecordedTime, JointsPoseByTheRobotDescriptionOfTheirTime) {
  for (const std::string type : {"prismatic", "fixed"}) {
    WrittenBag bag;
    bag.camera(0, 0);
    bag.text(0, "/robot_description", urdf(type, 0.1, 2));
    for (int i = 1; i <= 6; ++i) {
      if (i == 4) bag.text(kPeriod * 3.9, "/robot_description", urdf(type, 0.1, 0));
      sensor_msgs::JointState state;
      state.header.stamp = at(kPeriod * i);
      state.name = {"j"};
      state.position = {0};
      bag.add("/joint_states", at(kPeriod * i), state);
      bag.mesh(at(kPeriod * i + kDelay), at(kPeriod * i), "cloth");
    }
    EXPECT_EQ(statesOf(&bag), "---CCC") << type;
  }
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
