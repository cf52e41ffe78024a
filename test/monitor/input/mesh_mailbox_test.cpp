// Which mesh waits, and what becomes of those that do not.
#include "monitor/input/mesh_mailbox.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <string>
#include <thread>
#include <vector>

namespace deformable_contact_monitor {
namespace {

DeformableMesh::ConstPtr mesh(double stamp_s, std::vector<std::uint32_t> triangles = {},
                              const std::string& object = "cloth") {
  auto message = boost::make_shared<DeformableMesh>();
  message->header.stamp = ros::Time(stamp_s);
  message->object = object;
  message->triangles = std::move(triangles);
  return message;
}

class MeshMailboxTest : public ::testing::Test {
 protected:
  MeshMailbox mailbox_{"cloth"};
};

TEST_F(MeshMailboxTest, NothingWaitsAtFirst) {
  EXPECT_TRUE(mailbox_.isEmpty());
  EXPECT_FALSE(mailbox_.take());
  mailbox_.dropIf([](const ros::Time&) { return true; });
  EXPECT_EQ(mailbox_.counters().dropped, 0U);
}

TEST_F(MeshMailboxTest, AMeshIsTakenOnce) {
  const DeformableMesh::ConstPtr stored = mesh(50, {0, 1, 2});
  const auto before = std::chrono::steady_clock::now();
  mailbox_.store(stored);
  const std::optional<ArrivedMesh> taken = mailbox_.take();
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->message, stored);
  EXPECT_EQ(taken->keyframe, stored);
  EXPECT_GE(taken->arrival, before);
  EXPECT_LE(taken->arrival, std::chrono::steady_clock::now());
  EXPECT_TRUE(mailbox_.isEmpty());
  EXPECT_FALSE(mailbox_.take());
}

TEST_F(MeshMailboxTest, ItArrivedWhenItWasReceivedNotWhenItWasRead) {
  ReceivedMesh received{mesh(50)};
  received.waited_s = 0.25;
  const auto before = std::chrono::steady_clock::now();
  mailbox_.store(received);
  const auto after = std::chrono::steady_clock::now();
  const auto arrival = mailbox_.take()->arrival;
  EXPECT_GE(arrival, before - std::chrono::milliseconds(250));
  EXPECT_LE(arrival, after - std::chrono::milliseconds(250));
}

TEST_F(MeshMailboxTest, TheNewestWaitsOlderOnesAreDroppedAndCounted) {
  for (const double stamp_s : {50.0, 50.1, 50.2}) mailbox_.store(mesh(stamp_s));
  EXPECT_FALSE(mailbox_.isEmpty());
  EXPECT_EQ(mailbox_.counters().received, 3U);
  EXPECT_EQ(mailbox_.counters().dropped, 2U);
  EXPECT_EQ(mailbox_.take()->message->header.stamp, ros::Time(50.2));
}

TEST_F(MeshMailboxTest, TrianglesOfADroppedMessageAreKept) {
  const DeformableMesh::ConstPtr keyframe = mesh(50, {0, 1, 2});
  mailbox_.store(keyframe);
  mailbox_.store(mesh(50.1));
  mailbox_.dropIf([](const ros::Time&) { return true; });
  mailbox_.store(mesh(50.2));
  EXPECT_EQ(mailbox_.take()->keyframe, keyframe);
  mailbox_.store(mesh(50.3));
  EXPECT_EQ(mailbox_.take()->keyframe, nullptr) << "it was taken before";
}

TEST_F(MeshMailboxTest, AnotherObjectsTrianglesReplaceNone) {
  const DeformableMesh::ConstPtr ours = mesh(50, {0, 1, 2});
  mailbox_.store(ours);
  mailbox_.store(mesh(50.1, {2, 1, 0}, "cable"));
  EXPECT_EQ(mailbox_.take()->keyframe, ours);
}

TEST_F(MeshMailboxTest, OnlyWhatIsUnwantedIsDropped) {
  const auto late = [](const ros::Time& stamp) { return stamp > ros::Time(60); };
  mailbox_.store(mesh(50));
  mailbox_.dropIf(late);
  EXPECT_FALSE(mailbox_.isEmpty());
  mailbox_.store(mesh(61));
  mailbox_.dropIf(late);
  EXPECT_TRUE(mailbox_.isEmpty());
  EXPECT_EQ(mailbox_.counters().dropped, 2U);
}

// What was stored was either taken or counted as dropped, whatever the threads' order was.
TEST_F(MeshMailboxTest, NoMeshGetsLostBetweenThreads) {
  constexpr int kMeshes = 5000;
  std::thread publisher([this] {
    for (int i = 1; i <= kMeshes; ++i) mailbox_.store(mesh(i));
  });
  std::uint64_t taken = 0;
  for (ros::Time last; last != ros::Time(kMeshes);) {
    const std::optional<ArrivedMesh> mesh = mailbox_.take();
    if (!mesh) continue;
    EXPECT_GT(mesh->message->header.stamp, last);
    ++taken;
    last = mesh->message->header.stamp;
  }
  publisher.join();
  EXPECT_EQ(mailbox_.counters().received, static_cast<std::uint64_t>(kMeshes));
  EXPECT_EQ(taken + mailbox_.counters().dropped, static_cast<std::uint64_t>(kMeshes));
}

}  // namespace
}  // namespace deformable_contact_monitor
