// Tests of the check of a message's bytes: of valid ones, and of bytes that only claim to be one.
#include "monitor/input/message_bytes.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "mesh_messages.h"

namespace deformable_contact_monitor {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kMaxBytes = 4096;

void make(const TriangleMesh& mesh, DeformableMesh* message) { *message = asDeformableMesh(mesh); }
void make(const TriangleMesh& mesh, shape_msgs::Mesh* message) { *message = asShapeMesh(mesh); }
void make(const TriangleMesh& mesh, sensor_msgs::PointCloud2* message) {
  *message = asPointCloud(mesh);
}
void make(const TriangleMesh& mesh, visualization_msgs::Marker* message) {
  *message = asMarker(mesh);
  message->colors.resize(3);
  message->text = "some text";
  message->mesh_resource = "file:///cloth";
}
void make(const TriangleMesh& mesh, visualization_msgs::MarkerArray* message) {
  *message = asMarkerArray(mesh);
  make(mesh, &message->markers[1]);
}
void make(const TriangleMesh& mesh, geometry_msgs::PoseArray* message) {
  *message = asPoseArray(mesh);
}
#ifdef DCM_HAS_NAV_MSGS
void make(const TriangleMesh& mesh, nav_msgs::Path* message) { *message = asPath(mesh); }
#endif
#ifdef DCM_HAS_PCL_MSGS
void make(const TriangleMesh& mesh, pcl_msgs::PolygonMesh* message) {
  *message = asPolygonMesh(mesh);
}
#endif
void make(const TriangleMesh& mesh, LinkMeshes* message) {
  message->meshes.resize(2);
  message->meshes[0].link = "palm";
  message->meshes[0].source = "a test";
  message->meshes[1].vertices = mesh.vertices;
  message->meshes[1].triangles = mesh.triangles;
}
void make(const TriangleMesh& mesh, StatesToCheck* message) {
  message->joint_names = {"elbow", "wrist"};
  message->positions.assign(mesh.vertices.begin(), mesh.vertices.end());
  message->objects = {"cloth"};
}
void make(const TriangleMesh& /*mesh*/, tf2_msgs::TFMessage* message) {
  message->transforms.resize(2);
  message->transforms[0].header.frame_id = "base";
  message->transforms[1].child_frame_id = "palm";
}
void make(const TriangleMesh& mesh, sensor_msgs::JointState* message) {
  message->name = {"elbow", "wrist"};
  message->position.assign(mesh.vertices.begin(), mesh.vertices.end());
}

template <typename M>
class MessageBytes : public ::testing::Test {
 protected:
  MessageBytes() { make({{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, {0, 1, 2, 1, 3, 2}}, &message_); }

  static std::string why(const Bytes& bytes) {
    return validateMeshBytes<M>(bytes.data(), bytes.size(), kMaxBytes);
  }

  // Returns whether the bytes pass the check. Then roscpp reads them to a message with the same
  // bytes, so it takes no more memory than those.
  static bool passesRightly(Bytes bytes) {
    if (!why(bytes).empty()) return false;
    M message;
    ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    ros::serialization::deserialize(stream, message);
    EXPECT_EQ(serialized(message), bytes);
    return true;
  }

  M message_;
};

using Messages = ::testing::Types<DeformableMesh, shape_msgs::Mesh, visualization_msgs::Marker,
                                  visualization_msgs::MarkerArray,
#ifdef DCM_HAS_PCL_MSGS
                                  pcl_msgs::PolygonMesh,
#endif
#ifdef DCM_HAS_NAV_MSGS
                                  nav_msgs::Path,
#endif
                                  geometry_msgs::PoseArray, sensor_msgs::PointCloud2, LinkMeshes,
                                  StatesToCheck, tf2_msgs::TFMessage, sensor_msgs::JointState>;
TYPED_TEST_SUITE(MessageBytes, Messages);

TYPED_TEST(MessageBytes, AMessagePasses) {
  EXPECT_EQ(this->why(serialized(this->message_)), "");
  EXPECT_TRUE(this->passesRightly(serialized(this->message_)));
  EXPECT_EQ(this->why(serialized(TypeParam())), "") << "an empty one is a message";
}

#ifdef DCM_HAS_PCL_MSGS
// They take 4 bytes each in the message, and six times as many in memory.
TEST(PolygonMeshBytes, EmptyPolygonsAreRefusedBeforeTheyAreRead) {
  pcl_msgs::PolygonMesh message;
  message.polygons.resize(1000);
  const Bytes bytes = serialized(message);
  EXPECT_EQ(validateMeshBytes<pcl_msgs::PolygonMesh>(bytes.data(), bytes.size(), bytes.size()),
            "polygon 0 has 0 vertices, must have at least 3");
}
#endif

TYPED_TEST(MessageBytes, EveryCutIsRefusedAndSoIsWhatFollows) {
  const Bytes whole = serialized(this->message_);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(this->why(Bytes(whole.begin(), whole.begin() + size)), "") << size;
  }
  Bytes longer = whole;
  longer.push_back(0);
  EXPECT_EQ(this->why(longer), "1 bytes follow the message");
}

// Some of these lengths wrap to few bytes in 32 bits, and roscpp's own check does not see that.
TYPED_TEST(MessageBytes, AClaimAnywhereIsRefusedOrHarmless) {
  const Bytes whole = serialized(this->message_);
  int refused = 0;
  for (std::size_t at = 0; at + 4 <= whole.size(); ++at) {
    for (const std::uint32_t claim :
         {0xFFFFFFFFU, 0x7FFFFFFFU, 0x40000001U, 0x80000002U, 0x0AAAAAABU, 0x15555556U, 1000U}) {
      Bytes bytes = whole;
      std::memcpy(bytes.data() + at, &claim, sizeof claim);
      refused += !this->passesRightly(bytes);
    }
  }
  EXPECT_GE(refused, 2 * 7) << "there are two lengths at least";
}

TYPED_TEST(MessageBytes, WhatPassesIsWhatRoscppReads) {
  std::mt19937 random(5);
  const Bytes good = serialized(this->message_);
  int passed = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = good;
    bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (i % 3 == 0) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random() % 16);
    passed += this->passesRightly(bytes);
  }
  EXPECT_GT(passed, 5000);
}

TYPED_TEST(MessageBytes, AMessageOfTheLimitPassesAndALongerOneDoesNot) {
  const Bytes bytes = serialized(this->message_);
  EXPECT_EQ(validateMeshBytes<TypeParam>(bytes.data(), bytes.size(), bytes.size()), "");
  const std::string why =
      validateMeshBytes<TypeParam>(bytes.data(), bytes.size(), bytes.size() - 1);
  EXPECT_NE(why.find("more than max_mesh_mib allows"), std::string::npos) << why;
}

// A serialized message is a little longer than its arrays, as it has numbers as well.
TYPED_TEST(MessageBytes, TheArraysOfAMessageAreCounted) {
  const std::size_t count = byteCount(this->message_), whole = serialized(this->message_).size();
  EXPECT_LE(count, whole);
  EXPECT_GE(count + 200, whole);
  EXPECT_GE(count, 48U);
}

}  // namespace
}  // namespace deformable_contact_monitor
