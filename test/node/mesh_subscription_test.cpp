// Bytes that are a mesh, and bytes that claim to be one.
#include "node/mesh_subscription.h"

#include <gtest/gtest.h>
#include <ros/message_event.h>
#include <ros/serialization.h>
#include <ros/subscription_callback_helper.h>

#include <boost/make_shared.hpp>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kMaxBytes = 4096;

DeformableMesh sample() {
  DeformableMesh message;
  message.header.stamp = ros::Time(50.25);
  message.header.frame_id = "camera";
  message.object = "cloth";
  message.topology_id = 7;
  message.vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  message.triangles = {0, 1, 2};
  return message;
}

Bytes serialized(const DeformableMesh& message) {
  Bytes bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

std::string why(const Bytes& bytes) { return whyNoMesh(bytes.data(), bytes.size(), kMaxBytes); }

// Where the length of the vertices stands, counted from the end.
std::size_t verticesLengthAt(const DeformableMesh& message) {
  return serialized(message).size() - 8 - 4 * (message.vertices.size() + message.triangles.size());
}

void setWord(std::size_t at, std::uint32_t value, Bytes* bytes) {
  std::memcpy(bytes->data() + at, &value, sizeof value);
}

struct Received {
  DeformableMesh::ConstPtr message;
  std::string refusal;
};

class MeshSubscriptionTest : public ::testing::Test {
 protected:
  // As roscpp does with a message from the wire.
  Received arrive(Bytes bytes) {
    ros::SubscriptionCallbackHelperDeserializeParams params;
    params.buffer = bytes.data();
    params.length = static_cast<std::uint32_t>(bytes.size());
    return hand(options_.helper->deserialize(params));
  }

  // As it does with one of a publisher in the same process.
  Received hand(const ros::VoidConstPtr& message) {
    received_ = Received();
    ros::SubscriptionCallbackHelperCallParams params;
    params.event =
        ros::MessageEvent<void const>(message, boost::make_shared<ros::M_string>(), ros::Time(1),
                                      false, ros::MessageEvent<void const>::CreateFunction());
    options_.helper->call(params);
    return received_;
  }

  Received received_;
  const ros::SubscribeOptions options_ = meshSubscription(
      "/cloth", kMaxBytes, [this](const DeformableMesh::ConstPtr& message, const std::string& why) {
        received_ = {message, why};
      });
};

TEST_F(MeshSubscriptionTest, AMeshArrivesAsItWasSent) {
  const Received received = arrive(serialized(sample()));
  EXPECT_EQ(received.refusal, "");
  EXPECT_EQ(serialized(*received.message), serialized(sample()));
}

TEST_F(MeshSubscriptionTest, OneOfTheSameProcessComesWithoutACopy) {
  EXPECT_EQ(options_.helper->getTypeInfo(), typeid(DeformableMesh));
  const auto message = boost::make_shared<const DeformableMesh>(sample());
  const Received received = hand(message);
  EXPECT_EQ(received.message, message);
  EXPECT_EQ(received.refusal, "");
}

TEST_F(MeshSubscriptionTest, AClaimIsLookedAtBeforeMemoryIsTaken) {
  const std::size_t at = verticesLengthAt(sample());
  // The last two wrap to few bytes in 32 bits, which roscpp's own check does.
  for (const std::uint32_t claim : {0xFFFFFFFFU, 0x7FFFFFFFU, 0x40000001U, 0x80000002U}) {
    Bytes bytes = serialized(sample());
    setWord(at, claim, &bytes);
    const Received received = arrive(bytes);
    ASSERT_NE(received.message, nullptr);
    EXPECT_NE(received.refusal.find("vertices claims"), std::string::npos) << received.refusal;
    EXPECT_EQ(received.message->header.stamp, sample().header.stamp);
    EXPECT_TRUE(received.message->vertices.empty());
  }
}

TEST_F(MeshSubscriptionTest, EveryCutIsRefusedAndSoIsWhatFollows) {
  const Bytes whole = serialized(sample());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(arrive(Bytes(whole.begin(), whole.begin() + size)).refusal, "") << size;
  }
  Bytes longer = whole;
  longer.push_back(0);
  EXPECT_EQ(arrive(longer).refusal, "1 bytes follow the mesh");
}

TEST_F(MeshSubscriptionTest, ALargeMeshIsRefusedOnBothWays) {
  DeformableMesh large = sample();
  large.vertices.resize(kMaxBytes / sizeof(float));
  for (const Received& received :
       {arrive(serialized(large)), hand(boost::make_shared<const DeformableMesh>(large))}) {
    EXPECT_NE(received.refusal.find("max_mesh_mib"), std::string::npos) << received.refusal;
    EXPECT_EQ(received.message->header.stamp, large.header.stamp);
    EXPECT_TRUE(received.message->vertices.empty()) << "it must not be kept";
  }
}

// Against roscpp's own reading, where that is safe: what passes is read to the same bytes.
TEST_F(MeshSubscriptionTest, WhatPassesIsWhatRoscppReads) {
  std::mt19937 random(5);
  const Bytes good = serialized(sample());
  int passed = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = good;
    bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (i % 3 == 0) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random() % 16);
    if (!why(bytes).empty()) continue;
    ++passed;
    DeformableMesh message;
    ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    ros::serialization::deserialize(stream, message);
    EXPECT_EQ(serialized(message), bytes);
  }
  EXPECT_GT(passed, 5000);
}

}  // namespace
}  // namespace deformable_contact_monitor
