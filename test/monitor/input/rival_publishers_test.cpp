// Tests which publishers of one object are rivals.
#include "monitor/input/rival_publishers.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;

const SteadyTime kStart{std::chrono::hours(7)};
const std::string kBoth =
    "two nodes publish different meshes of it in turn: /a and /b; stop one of them, or give them a "
    "topic and an object each";

class RivalPublishersTest : public ::testing::Test {
 protected:
  // A mesh at height `z` [m] from that node. Returns what is said then.
  std::string send(const std::string& node, int ms, float z, bool is_deletion = false,
                   const std::vector<std::uint32_t>& triangles = {}) {
    const auto message = boost::make_shared<DeformableMesh>();
    message->triangles = triangles;
    message->header.frame_id = "base";
    message->vertices = {0, 0, z, 1, 0, z, std::numeric_limits<float>::quiet_NaN(), 1, z};
    IncomingMesh mesh{message};
    mesh.publisher = node;
    mesh.arrival = kStart + milliseconds(ms);
    mesh.is_deletion = is_deletion;
    rivals_.look(mesh);
    return rivals_.describe(mesh.arrival);
  }

  RivalPublishers rivals_;
};

TEST_F(RivalPublishersTest, OneThatMovesHasNoRival) {
  for (int i = 0; i < 10; ++i) EXPECT_EQ(send("/a", 33 * i, static_cast<float>(i)), "");
}

TEST_F(RivalPublishersTest, WhoSendsSomethingElseInTurnIsOne) {
  EXPECT_EQ(send("/b", 0, 0), "");
  EXPECT_EQ(send("/a", 16, 1), "") << "it may have taken the place of the other";
  EXPECT_EQ(send("/b", 33, 0), kBoth);
  EXPECT_EQ(send("/a", 49, 1), kBoth);
  EXPECT_EQ(rivals_.describe(kStart + milliseconds(5049)), kBoth);
  EXPECT_EQ(rivals_.describe(kStart + milliseconds(5050)), "") << "it is over";
}

TEST_F(RivalPublishersTest, AlsoWithOtherTrianglesAlone) {
  for (int i = 0; i < 3; ++i) {
    send("/a", 33 * i, 0, false, {0, 1, 2});
    EXPECT_EQ(send("/b", 33 * i + 9, 0), "") << "it leaves them out";
  }
  send("/b", 100, 0, false, {0, 2, 1});
  send("/a", 110, 0, false, {0, 1, 2});
  EXPECT_EQ(send("/b", 120, 0, false, {0, 2, 1}), kBoth);
}

TEST_F(RivalPublishersTest, AlsoAtDifferentRates) {
  for (int ms = 0; ms < 1000; ms += 10) send("/a", ms, static_cast<float>(ms));
  send("/b", 1000, -1);
  EXPECT_EQ(send("/a", 1010, 1010), kBoth);
}

TEST_F(RivalPublishersTest, ANodeThatTakesThePlaceOfAnotherIsNone) {
  for (int i = 0; i < 10; ++i) send("/a", 33 * i, 0);
  for (int i = 10; i < 20; ++i) EXPECT_EQ(send("/b", 33 * i, 1), "");
  for (int i = 20; i < 30; ++i) send("/c", 33 * i, 2);
  EXPECT_EQ(send("/b", 990 + 5000, 1), "") << "of long ago nothing is known";
}

TEST_F(RivalPublishersTest, NodesThatSendTheSameAreNone) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(send("/a", 33 * i, static_cast<float>(i)), "");
    EXPECT_EQ(send("/b", 33 * i + 5, static_cast<float>(i)), "");
  }
}

TEST_F(RivalPublishersTest, ADeletionIsNoMesh) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(send("/a", 33 * i, 0), "");
    EXPECT_EQ(send("/b", 33 * i + 5, 1, true), "");
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
