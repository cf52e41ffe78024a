// Tests of meshes that arrive from the wire and from the same process.
#include "monitor/input/mesh_subscription.h"

#include <gtest/gtest.h>
#include <ros/message_event.h>
#include <ros/subscription_callback_helper.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
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

// Returns where the length of the vertices stands in the bytes, counted from their end.
std::size_t verticesLengthAt(const DeformableMesh& message) {
  return serialized(message).size() - 8 - 4 * (message.vertices.size() + message.triangles.size());
}

void setWord(std::size_t at, std::uint32_t value, Bytes* bytes) {
  std::memcpy(bytes->data() + at, &value, sizeof value);
}

class MeshSubscriptionTest : public ::testing::Test {
 protected:
  // Hands a message over as roscpp does if it comes from the wire.
  IncomingMesh arrive(Bytes bytes) {
    ros::SubscriptionCallbackHelperDeserializeParams params;
    params.buffer = bytes.data();
    params.length = static_cast<std::uint32_t>(bytes.size());
    return hand(options_.helper->deserialize(params));
  }

  // Hands a message over as roscpp does if its publisher is in the same process. The header is that
  // of one connection.
  IncomingMesh hand(const ros::VoidConstPtr& message) {
    received_ = IncomingMesh();
    ros::SubscriptionCallbackHelperCallParams params;
    params.event = ros::MessageEvent<void const>(message, header_, receipt_, false,
                                                 ros::MessageEvent<void const>::CreateFunction());
    options_.helper->call(params);
    return received_;
  }

  ros::SubscribeOptions subscribe(const ObjectParameters& object) {
    return meshSubscription("/cloth", object, kMaxBytes,
                            [this](const IncomingMesh& mesh) { received_ = mesh; });
  }

  boost::shared_ptr<ros::M_string> header_ = boost::make_shared<ros::M_string>();
  ros::Time receipt_ = kReceipt;
  IncomingMesh received_;
  ros::SubscribeOptions options_ = subscribe(ObjectParameters());
};

TEST_F(MeshSubscriptionTest, AMeshArrivesAsItWasSent) {
  const IncomingMesh received = arrive(serialized(sample()));
  EXPECT_EQ(received.problem, "");
  EXPECT_EQ(serialized(*received.message), serialized(sample()));
}

TEST_F(MeshSubscriptionTest, AMeshNamesTheConnectionByWhichItCame) {
  EXPECT_EQ(arrive(serialized(sample())).connection, header_);
  const auto before = std::exchange(header_, boost::make_shared<ros::M_string>());
  EXPECT_NE(arrive(serialized(sample())).connection, before);
  EXPECT_EQ(received_.connection, header_);
  header_ = nullptr;
  EXPECT_EQ(arrive(serialized(sample())).connection, nullptr);
}

// The cycle's budget (budget_ms) includes the time that a message waited.
TEST_F(MeshSubscriptionTest, HowLongAMessageWaitedIsKnownByARealClockAlone) {
  const ros::WallTime now = ros::WallTime::now();
  struct Bounds {
    double least, most;
  };
  const auto waitedS = [&](double s) -> Bounds {
    receipt_ = ros::Time(now.sec, now.nsec) - ros::Duration(s);
    const auto before = std::chrono::steady_clock::now();
    const auto arrival = arrive(serialized(sample())).arrival;
    return {toSeconds(before - arrival), toSeconds(std::chrono::steady_clock::now() - arrival)};
  };
  ros::Time::init();
  EXPECT_GE(waitedS(0.25).most, 0.25);
  EXPECT_LT(waitedS(0.25).least, 9);
  EXPECT_LE(waitedS(-60).least, 0) << "the clock was set back";
  EXPECT_LE(waitedS(60).least, 0) << "or forward";
  ros::Time::setNow(ros::Time(now.sec, now.nsec));  // a simulated clock
  EXPECT_LE(waitedS(0.25).least, 0);
  ros::Time::shutdown();
}

TEST_F(MeshSubscriptionTest, OneOfTheSameProcessComesWithoutACopy) {
  EXPECT_EQ(options_.helper->getTypeInfo(), typeid(DeformableMesh));
  const auto message = boost::make_shared<const DeformableMesh>(sample());
  const IncomingMesh received = hand(message);
  EXPECT_EQ(received.message, message);
  EXPECT_EQ(received.problem, "");
}

TEST_F(MeshSubscriptionTest, AClaimIsLookedAtBeforeMemoryIsTaken) {
  const std::size_t at = verticesLengthAt(sample());
  // In 32 bits the last two wrap to few bytes, and roscpp's own check does not see that.
  for (const std::uint32_t claim : {0xFFFFFFFFU, 0x7FFFFFFFU, 0x40000001U, 0x80000002U}) {
    Bytes bytes = serialized(sample());
    setWord(at, claim, &bytes);
    const IncomingMesh received = arrive(bytes);
    ASSERT_NE(received.message, nullptr);
    EXPECT_NE(received.problem.find("vertices claims"), std::string::npos) << received.problem;
    EXPECT_EQ(received.message->header.stamp, sample().header.stamp);
    EXPECT_TRUE(received.message->vertices.empty());
  }
}

TEST_F(MeshSubscriptionTest, EveryCutIsRefusedAndSoIsWhatFollows) {
  const Bytes whole = serialized(sample());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(arrive(Bytes(whole.begin(), whole.begin() + size)).problem, "") << size;
  }
  Bytes longer = whole;
  longer.push_back(0);
  EXPECT_EQ(arrive(longer).problem, "1 bytes follow the message");
}

TEST_F(MeshSubscriptionTest, ALargeMeshIsRefusedOnBothWays) {
  DeformableMesh large = sample();
  large.vertices.resize(kMaxBytes / sizeof(float));
  for (const IncomingMesh& received :
       {arrive(serialized(large)), hand(boost::make_shared<const DeformableMesh>(large))}) {
    EXPECT_NE(received.problem.find("max_mesh_mib"), std::string::npos) << received.problem;
    EXPECT_EQ(received.message->header.stamp, large.header.stamp);
    EXPECT_TRUE(received.message->vertices.empty()) << "it must not be kept";
  }
}

constexpr MeshType kAdapted[] = {
    MeshType::kShapeMesh,    MeshType::kMarker,        MeshType::kPointCloud,
    MeshType::kMarkerArray,  MeshType::kTetrahedra,    MeshType::kPoints,
    MeshType::kPolyline,     MeshType::kPolylinePoses, MeshType::kPolylineMarker,
#ifdef DCM_HAS_PCL_MSGS
    MeshType::kPolygonMesh,
#endif
#ifdef DCM_HAS_NAV_MSGS
    MeshType::kPolylinePath,
#endif
};

// Runs each test with every message type that is converted.
class AdaptedSubscriptionTest : public MeshSubscriptionTest,
                                public ::testing::WithParamInterface<MeshType> {
 protected:
  AdaptedSubscriptionTest() { options_ = subscribe(objectOf(GetParam())); }

  static ObjectParameters objectOf(MeshType type) {
    ObjectParameters object;
    object.type = type;
    object.frame_id = "camera";
    object.marker = {"cloth", 2};
    object.faces = std::make_shared<const PointTriangles>(trianglesOf(triangle()));
    return object;
  }

  static TriangleMesh triangle() { return {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}}; }

  // Returns the triangles that a message of triangle() becomes.
  static std::vector<std::uint32_t> expectedTriangles() {
    if (GetParam() == MeshType::kPoints) return {0, 0, 0, 1, 1, 1, 2, 2, 2};
    if (GetParam() >= MeshType::kPolyline) return {0, 1, 1, 1, 2, 2};
    return {0, 1, 2};
  }

  static ros::VoidConstPtr messageOf(const TriangleMesh& mesh, Bytes* bytes) {
    switch (GetParam()) {
      case MeshType::kShapeMesh:
        return shared(asShapeMesh(mesh), bytes);
      case MeshType::kMarker:
        return shared(asMarker(mesh), bytes);
      case MeshType::kMarkerArray:
        return shared(asMarkerArray(mesh), bytes);
#ifdef DCM_HAS_PCL_MSGS
      case MeshType::kPolygonMesh:
        return shared(asPolygonMesh(mesh), bytes);
#endif
      case MeshType::kPolylinePoses:
        return shared(asPoseArray(mesh), bytes);
#ifdef DCM_HAS_NAV_MSGS
      case MeshType::kPolylinePath:
        return shared(asPath(mesh), bytes);
#endif
      case MeshType::kPolylineMarker:
        return shared(asLineStrip(mesh), bytes);
      default:
        return shared(asPointCloud(mesh), bytes);
    }
  }

  template <typename M>
  static ros::VoidConstPtr shared(const M& message, Bytes* bytes) {
    *bytes = serialized(message);
    return boost::make_shared<const M>(message);
  }

  // Returns the mesh's stamp: kSent, or the time of receipt if the message type has no stamp.
  static ros::Time stamp() { return GetParam() == MeshType::kShapeMesh ? kReceipt : kSent; }
  // An array that is rejected has no stamp: its markers have one each.
  static ros::Time stampOfRejected() {
    return GetParam() == MeshType::kMarkerArray ? kReceipt : stamp();
  }
};

TEST_P(AdaptedSubscriptionTest, AMessageArrivesAsAMeshOnBothWays) {
  Bytes bytes;
  const ros::VoidConstPtr message = messageOf(triangle(), &bytes);
  const IncomingMesh of_process = hand(message);
  EXPECT_EQ(of_process.problem, "");
  EXPECT_EQ(of_process.message->vertices, triangle().vertices);
  EXPECT_EQ(of_process.message->triangles, expectedTriangles());
  const IncomingMesh of_wire = arrive(bytes);
  EXPECT_EQ(of_wire.problem, "");
  EXPECT_EQ(of_wire.message->vertices, triangle().vertices);
  EXPECT_TRUE(of_wire.message->triangles.empty()) << "they are the same";
  EXPECT_EQ(of_wire.message->topology_id, of_process.message->topology_id);
  EXPECT_EQ(of_wire.connection, nullptr) << "they hold for all publishers";
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
  const std::vector<IncomingMesh> all = {hand(message), arrive(bytes), arrive(cut)};
  for (const IncomingMesh& mesh : all) {
    EXPECT_NE(mesh.problem, "");
    EXPECT_EQ(mesh.message->header.stamp, stampOfRejected());
    EXPECT_TRUE(mesh.message->vertices.empty());
  }
  for (int i = 0; i < 2; ++i) {
    EXPECT_NE(all[i].problem.find("max_mesh_mib"), std::string::npos) << all[i].problem;
  }
}

TEST_P(AdaptedSubscriptionTest, TheTypeIsTheObjects) {
  EXPECT_EQ(options_.datatype, messageType(GetParam()));
  EXPECT_NE(options_.datatype, messageType(MeshType::kDeformableMesh));
}

// The message itself stays as it is: it is not copied for another stamp.
TEST_F(MeshSubscriptionTest, StampsAreCorrectedByTheObjectsOffset) {
  ObjectParameters object;
  object.stamp_offset_s = -0.5;
  options_ = subscribe(object);
  DeformableMesh message = sample();
  const auto of_process = boost::make_shared<const DeformableMesh>(message);
  EXPECT_EQ(hand(of_process).stamp(), ros::Time(49.75));
  EXPECT_EQ(received_.message, of_process);
  EXPECT_EQ(arrive(serialized(message)).stamp(), ros::Time(49.75));
  message.header.stamp = ros::Time(0.5);
  EXPECT_EQ(arrive(serialized(message)).problem, "header.stamp plus stamp_offset_s is no time");
  message.header.stamp = ros::Time(0.75);
  EXPECT_EQ(arrive(serialized(message)).stamp(), ros::Time(0.25));
  message.header.stamp = ros::Time();
  EXPECT_TRUE(arrive(serialized(message)).stamp().isZero()) << "which is rejected later";

  object.stamp_offset_s = 5;
  options_ = subscribe(object);
  message.header.stamp = ros::Time(0xFFFFFFFFU - 5, 999999999);
  EXPECT_EQ(arrive(serialized(message)).stamp(), ros::Time(0xFFFFFFFFU, 999999999));
  message.header.stamp.sec += 1;
  EXPECT_EQ(arrive(serialized(message)).problem, "header.stamp plus stamp_offset_s is no time");
}

TEST_F(MeshSubscriptionTest, AMeshThatIsStampedOnReceiptIsCorrectedToo) {
  ObjectParameters object;
  object.type = MeshType::kShapeMesh;
  object.frame_id = "camera";
  object.stamp_offset_s = -0.5;
  options_ = subscribe(object);
  const Bytes bytes = serialized(asShapeMesh({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}}));
  EXPECT_EQ(arrive(bytes).stamp(), kReceipt - ros::Duration(0.5));
}

TEST_F(MeshSubscriptionTest, AnArrayWithoutTheMarkerIsNoMesh) {
  ObjectParameters object;
  object.type = MeshType::kMarkerArray;
  object.marker = {"cloth", 2};
  options_ = subscribe(object);
  visualization_msgs::MarkerArray array = asMarkerArray({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}});
  EXPECT_NE(arrive(serialized(array)).message, nullptr);
  array.markers.pop_back();
  EXPECT_EQ(arrive(serialized(array)).message, nullptr) << "it was handed over";
}

INSTANTIATE_TEST_SUITE_P(Types, AdaptedSubscriptionTest, ::testing::ValuesIn(kAdapted));

}  // namespace
}  // namespace deformable_contact_monitor
