// Bytes that are a mesh, and bytes that claim to be one.
#include "monitor/input/mesh_subscription.h"

#include <gtest/gtest.h>
#include <ros/message_event.h>
#include <ros/subscription_callback_helper.h>

#include <boost/make_shared.hpp>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "mesh_messages.h"

namespace deformable_contact_monitor {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kMaxBytes = 4096;
const ros::Time kReceipt(51);

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

// Where the length of the vertices stands, counted from the end.
std::size_t verticesLengthAt(const DeformableMesh& message) {
  return serialized(message).size() - 8 - 4 * (message.vertices.size() + message.triangles.size());
}

void setWord(std::size_t at, std::uint32_t value, Bytes* bytes) {
  std::memcpy(bytes->data() + at, &value, sizeof value);
}

class MeshSubscriptionTest : public ::testing::Test {
 protected:
  // As roscpp does with a message from the wire.
  ReceivedMesh arrive(Bytes bytes) {
    ros::SubscriptionCallbackHelperDeserializeParams params;
    params.buffer = bytes.data();
    params.length = static_cast<std::uint32_t>(bytes.size());
    return hand(options_.helper->deserialize(params));
  }

  // As it does with one of a publisher in the same process.
  ReceivedMesh hand(const ros::VoidConstPtr& message) {
    received_ = ReceivedMesh();
    ros::SubscriptionCallbackHelperCallParams params;
    params.event =
        ros::MessageEvent<void const>(message, boost::make_shared<ros::M_string>(), receipt_, false,
                                      ros::MessageEvent<void const>::CreateFunction());
    options_.helper->call(params);
    return received_;
  }

  ros::SubscribeOptions subscribe(const ObjectParameters& object) {
    return meshSubscription(
        "/cloth", object, kMaxBytes, [this](const ReceivedMesh& mesh) { received_ = mesh; },
        [this] { received_when_expected_.push_back(received_.message != nullptr); });
  }

  ros::Time receipt_ = kReceipt;
  ReceivedMesh received_;
  std::vector<bool> received_when_expected_;
  ros::SubscribeOptions options_ = subscribe(ObjectParameters());
};

TEST_F(MeshSubscriptionTest, AnyMessageIsExpectedAheadOfItsArrival) {
  arrive(serialized(sample()));
  received_ = ReceivedMesh();
  EXPECT_NE(arrive(Bytes(3)).refusal, "");
  EXPECT_EQ(received_when_expected_, std::vector<bool>({false, false}));
}

TEST_F(MeshSubscriptionTest, AMeshArrivesAsItWasSent) {
  const ReceivedMesh received = arrive(serialized(sample()));
  EXPECT_EQ(received.refusal, "");
  EXPECT_EQ(serialized(*received.message), serialized(sample()));
}

// A budget counts that time.
TEST_F(MeshSubscriptionTest, HowLongAMessageWaitedIsKnownByARealClockAlone) {
  const ros::WallTime now = ros::WallTime::now();
  const auto waitedS = [&](double s) {
    receipt_ = ros::Time(now.sec, now.nsec) - ros::Duration(s);
    return arrive(serialized(sample())).waited_s;
  };
  ros::Time::init();
  EXPECT_GE(waitedS(0.25), 0.25);
  EXPECT_LT(waitedS(0.25), 9);
  EXPECT_EQ(waitedS(-60), 0) << "the clock was set back";
  EXPECT_EQ(waitedS(60), 0) << "or forward";
  ros::Time::setNow(ros::Time(now.sec, now.nsec));  // a simulated clock
  EXPECT_EQ(waitedS(0.25), 0);
  ros::Time::shutdown();
}

TEST_F(MeshSubscriptionTest, OneOfTheSameProcessComesWithoutACopy) {
  EXPECT_EQ(options_.helper->getTypeInfo(), typeid(DeformableMesh));
  const auto message = boost::make_shared<const DeformableMesh>(sample());
  const ReceivedMesh received = hand(message);
  EXPECT_EQ(received.message, message);
  EXPECT_EQ(received.refusal, "");
}

TEST_F(MeshSubscriptionTest, AClaimIsLookedAtBeforeMemoryIsTaken) {
  const std::size_t at = verticesLengthAt(sample());
  // The last two wrap to few bytes in 32 bits, which roscpp's own check does.
  for (const std::uint32_t claim : {0xFFFFFFFFU, 0x7FFFFFFFU, 0x40000001U, 0x80000002U}) {
    Bytes bytes = serialized(sample());
    setWord(at, claim, &bytes);
    const ReceivedMesh received = arrive(bytes);
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
  for (const ReceivedMesh& received :
       {arrive(serialized(large)), hand(boost::make_shared<const DeformableMesh>(large))}) {
    EXPECT_NE(received.refusal.find("max_mesh_mib"), std::string::npos) << received.refusal;
    EXPECT_EQ(received.message->header.stamp, large.header.stamp);
    EXPECT_TRUE(received.message->vertices.empty()) << "it must not be kept";
  }
}

constexpr MeshType kAdapted[] = {MeshType::kShapeMesh, MeshType::kMarker, MeshType::kPointCloud};

// A triangle on the wire, and the whole message in the process.
class AdaptedSubscriptionTest : public MeshSubscriptionTest,
                                public ::testing::WithParamInterface<MeshType> {
 protected:
  AdaptedSubscriptionTest() { options_ = subscribe(objectOf(GetParam())); }

  static ObjectParameters objectOf(MeshType type) {
    ObjectParameters object;
    object.type = type;
    object.frame_id = "camera";
    object.faces = std::make_shared<const TriangleMesh>(triangle());
    return object;
  }

  static TriangleMesh triangle() { return {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}}; }

  static ros::VoidConstPtr messageOf(const TriangleMesh& mesh, Bytes* bytes) {
    switch (GetParam()) {
      case MeshType::kShapeMesh:
        return shared(asShapeMesh(mesh), bytes);
      case MeshType::kMarker:
        return shared(asMarker(mesh), bytes);
      default:
        return shared(asPointCloud(mesh), bytes);
    }
  }

  template <typename M>
  static ros::VoidConstPtr shared(const M& message, Bytes* bytes) {
    *bytes = serialized(message);
    return boost::make_shared<const M>(message);
  }

  // kSent, or where the message has no stamp that of its receipt.
  static ros::Time stamp() { return GetParam() == MeshType::kShapeMesh ? kReceipt : kSent; }
};

TEST_P(AdaptedSubscriptionTest, AMessageArrivesAsAMeshOnBothWays) {
  Bytes bytes;
  const ros::VoidConstPtr message = messageOf(triangle(), &bytes);
  const ReceivedMesh of_process = hand(message);
  EXPECT_EQ(of_process.refusal, "");
  EXPECT_EQ(of_process.message->vertices, triangle().vertices);
  EXPECT_EQ(of_process.message->triangles, triangle().triangles);
  const ReceivedMesh of_wire = arrive(bytes);
  EXPECT_EQ(of_wire.refusal, "");
  EXPECT_EQ(of_wire.message->vertices, triangle().vertices);
  EXPECT_TRUE(of_wire.message->triangles.empty()) << "they are the same";
  EXPECT_EQ(of_wire.message->topology_id, of_process.message->topology_id);
  EXPECT_EQ(of_wire.message->header.stamp, stamp());
  EXPECT_EQ(of_wire.message->header.frame_id, "camera");
}

TEST_P(AdaptedSubscriptionTest, WhatIsRefusedHasAStampAndAReason) {
  TriangleMesh large = triangle();
  large.vertices.resize(kMaxBytes / 4 / 9 * 9 + 9);
  large.triangles.resize(large.vertices.size() / 3);
  Bytes bytes;
  const ros::VoidConstPtr message = messageOf(large, &bytes);
  Bytes cut = bytes;
  cut.resize(60);
  const std::vector<ReceivedMesh> all = {hand(message), arrive(bytes), arrive(cut)};
  for (const ReceivedMesh& mesh : all) {
    EXPECT_NE(mesh.refusal, "");
    EXPECT_EQ(mesh.message->header.stamp, stamp());
    EXPECT_TRUE(mesh.message->vertices.empty());
  }
  for (int i = 0; i < 2; ++i) {
    EXPECT_NE(all[i].refusal.find("max_mesh_mib"), std::string::npos) << all[i].refusal;
  }
}

TEST_P(AdaptedSubscriptionTest, TheTypeIsTheObjects) {
  EXPECT_EQ(options_.datatype, messageType(GetParam()));
  EXPECT_NE(options_.datatype, messageType(MeshType::kDeformableMesh));
}

INSTANTIATE_TEST_SUITE_P(Types, AdaptedSubscriptionTest, ::testing::ValuesIn(kAdapted));

}  // namespace
}  // namespace deformable_contact_monitor
