// Tests that the bytes of a bag become messages only if they are exactly one message of the type.
#include "tools/bags/bag_messages.h"

#include <geometry_msgs/PoseArray.h>
#include <gtest/gtest.h>
#include <ros/serialization.h>
#include <sensor_msgs/PointCloud2.h>
#include <shape_msgs/Mesh.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "monitor/input/optional_messages.h"
#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

// Returns a message as a bag has it.
template <class M>
BagMessage recorded(const M& message) {
  BagMessage bag;
  bag.topic = "/topic";
  bag.type = ros::message_traits::datatype<M>();
  bag.md5 = ros::message_traits::md5sum<M>();
  bag.received = ros::Time(9.5);
  bag.clock = ros::Time(7.5);
  bag.bytes.resize(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bag.bytes.data(),
                                     static_cast<std::uint32_t>(bag.bytes.size()));
  ros::serialization::serialize(stream, message);
  return bag;
}

std_msgs::Header headerIn(const std::string& frame) {
  std_msgs::Header header;
  header.stamp = ros::Time(3.25);
  header.frame_id = frame;
  return header;
}

LinkMeshes linkMeshes() {
  LinkMeshes links;
  links.header = headerIn("base");
  links.meshes.resize(2);
  links.meshes[0].link = "hand";
  links.meshes[1].source = "hand.stl";
  links.meshes[1].vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  links.meshes[1].triangles = {0, 1, 2};
  return links;
}

tf2_msgs::TFMessage transforms() {
  tf2_msgs::TFMessage all;
  all.transforms.resize(2);
  for (geometry_msgs::TransformStamped& transform : all.transforms) {
    transform.header = headerIn("base");
    transform.child_frame_id = "hand";
    transform.transform.rotation.w = 1;
  }
  return all;
}

sensor_msgs::JointState jointState() {
  sensor_msgs::JointState state;
  state.header = headerIn("base");
  state.name = {"elbow", "wrist"};
  state.position = {0.5, 0.25};
  state.velocity = {1};
  state.effort = {2, 3, 4};
  return state;
}

std_msgs::String text() {
  std_msgs::String text;
  text.data = "<robot/>";
  return text;
}

// A message, how it is read, and the names of its fields that have lengths.
struct Case {
  BagMessage message;
  std::function<void(const BagMessage&)> read;
  std::vector<std::string> fields;
};

void headOfMesh(const BagMessage& message) { headOf(message, ObjectParameters()); }

std::vector<Case> allTypes() {
  sensor_msgs::PointCloud2 cloud;
  cloud.header = headerIn("camera");
  cloud.fields.resize(1);
  cloud.data.resize(12);
  visualization_msgs::Marker marker;
  marker.header = headerIn("camera");
  marker.points.resize(3);
  shape_msgs::Mesh shape;
  shape.vertices.resize(3);
  shape.triangles.resize(1);
  geometry_msgs::PoseArray poses;
  poses.header = headerIn("camera");
  poses.poses.resize(3);
  DeformableMesh mesh;
  mesh.header = headerIn("camera");
  mesh.vertices.resize(9);
  mesh.triangles = {0, 1, 2};
  std::vector<Case> all = {
      {recorded(linkMeshes()),
       toLinkMeshes,
       {"header", "meshes", "meshes.link", "meshes.source", "meshes.vertices", "meshes.triangles"}},
      {recorded(transforms()),
       toTransforms,
       {"transforms", "header", "transforms.child_frame_id", "transforms.transform"}},
      {recorded(jointState()), toJointState, {"header", "name", "position", "velocity", "effort"}},
      {recorded(text()), toText, {"data"}},
      {recorded(mesh), headOfMesh, {"header", "vertices", "triangles"}},
      {recorded(shape), headOfMesh, {"vertices", "triangles"}},
      {recorded(marker), headOfMesh, {"header", "points"}},
      {recorded(cloud), headOfMesh, {"header", "fields", "data"}},
      {recorded(poses), headOfMesh, {"header", "poses"}},
  };
#ifdef DCM_HAS_NAV_MSGS
  nav_msgs::Path path;
  path.header = headerIn("camera");
  path.poses.resize(2);
  path.poses[1].header = headerIn("camera");
  all.push_back({recorded(path), headOfMesh, {"header", "poses", "poses.pose"}});
#endif
  return all;
}

TEST(BagMessages, AnArrayHasTheHeaderOfTheObjectsMarker) {
  visualization_msgs::MarkerArray array;
  array.markers.resize(2);
  array.markers[0].header = headerIn("base");
  array.markers[1].header = headerIn("camera");
  array.markers[1].id = 7;
  ObjectParameters object;
  object.marker = {"", 7};
  EXPECT_EQ(headerOf(recorded(array), object), headerIn("camera"));
  object.marker = {"", 8};
  EXPECT_EQ(headerOf(recorded(array), object), std_msgs::Header());
}

std::string refusalOf(const Case& of) {
  return refusal<std::runtime_error>([&of] { of.read(of.message); });
}

TEST(BagMessages, AreReadAsTheyWereWritten) {
  EXPECT_EQ(toLinkMeshes(recorded(linkMeshes())), linkMeshes());
  EXPECT_EQ(toTransforms(recorded(transforms())), transforms());
  EXPECT_EQ(toJointState(recorded(jointState())), jointState());
  EXPECT_EQ(toText(recorded(text())), "<robot/>");
  EXPECT_EQ(headerOf(recorded(linkMeshes()), ObjectParameters()), headerIn("base"));
  sensor_msgs::JointState unstamped = jointState();
  unstamped.header.stamp = ros::Time();
  EXPECT_EQ(toJointState(recorded(unstamped)).header.stamp, ros::Time(7.5));
  for (const Case& whole : allTypes()) EXPECT_EQ(refusalOf(whole), "") << whole.message.type;
}

// The beginnings of a message, and what four bytes make of it that may be a length.
std::vector<Case> damagedOnes(const Case& whole) {
  std::vector<Case> damaged;
  const std::size_t size = whole.message.bytes.size();
  for (std::size_t left = 0; left < size; ++left) {
    damaged.push_back(whole);
    damaged.back().message.bytes.resize(left);
  }
  for (std::size_t at = 0; at + 4 <= size; ++at) {
    for (const std::uint8_t byte : {0xFF, 0x1F}) {
      damaged.push_back(whole);
      std::fill_n(damaged.back().message.bytes.begin() + static_cast<std::ptrdiff_t>(at), 4, byte);
    }
  }
  return damaged;
}

// They are refused before memory is taken for what they claim, and some refusal names each field.
TEST(BagMessages, ThatEndTooSoonOrClaimTooMuchAreRefusedByField) {
  for (const Case& whole : allTypes()) {
    std::string all;
    for (const Case& damaged : damagedOnes(whole)) {
      const std::string why = refusalOf(damaged);
      const bool is_shorter = damaged.message.bytes.size() < whole.message.bytes.size();
      if (why.empty() && !is_shorter) continue;  // no length is there
      EXPECT_EQ(why.rfind("/topic: a message is damaged: ", 0), 0U)
          << whole.message.type << ": " << why;
      all += why + "\n";
    }
    for (const std::string& field : whole.fields) expectIn(" " + field, all);
  }
}

TEST(BagMessages, WithBytesBehindTheirFieldsAreRefused) {
  for (Case longer : allTypes()) {
    longer.message.bytes.resize(longer.message.bytes.size() + 3);
    expectIn("/topic: a message is damaged: 3 bytes follow ", refusalOf(longer));
  }
}

TEST(BagMessages, OfAnotherDefinitionAreRefused) {
  for (Case other : allTypes()) {
    other.message.md5[0] = other.message.md5[0] == '0' ? '1' : '0';
    EXPECT_EQ(refusalOf(other), "/topic: another version of " + other.message.type);
  }
}

TEST(BagMessages, TransformsOfBeforeTf2AreTheSame) {
  BagMessage old = recorded(transforms());
  old.type = "tf/tfMessage";
  old.md5 = "94810edda583a504dfda3829e70d7eec";
  EXPECT_TRUE(isTransforms(old));
  EXPECT_EQ(toTransforms(old), transforms());
  old.md5[0] = '0';
  EXPECT_EQ(refusal<std::runtime_error>([&] { toTransforms(old); }),
            "/topic: another version of tf/tfMessage");
}

}  // namespace
}  // namespace deformable_contact_monitor
