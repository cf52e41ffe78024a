// What a mesh input accepts, refuses and keeps.
#include "monitor/input/mesh_input.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <limits>
#include <string>

namespace deformable_contact_monitor {
namespace {

const ros::Time kNow(50.25);
const MeshLimits kLimits{0.5, 1U << 20U};

boost::shared_ptr<DeformableMesh> mesh(double stamp_s, std::uint32_t topology_id = 1) {
  auto message = boost::make_shared<DeformableMesh>();
  message->header.stamp = ros::Time(stamp_s);
  message->header.frame_id = "camera";
  message->object = "cloth";
  message->topology_id = topology_id;
  message->vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  return message;
}

boost::shared_ptr<DeformableMesh> keyframe(double stamp_s, std::uint32_t topology_id = 1,
                                           std::vector<std::uint32_t> triangles = {0, 1, 2}) {
  auto message = mesh(stamp_s, topology_id);
  message->triangles = std::move(triangles);
  return message;
}

class MeshInputTest : public ::testing::Test {
 protected:
  Acceptance give(const DeformableMesh::ConstPtr& message, const ros::Time& now = kNow) {
    mailbox_.store(message);
    return input_.accept(*mailbox_.take(), now);
  }

  const AcceptedMesh* at(double t_s) { return input_.newestAt(ros::Time(t_s), &why_not_); }

  void expectRefused(const DeformableMesh::ConstPtr& message, const std::string& what) {
    EXPECT_EQ(give(message), Acceptance::kRefused);
    EXPECT_NE(input_.counters().refusal.find(what), std::string::npos) << input_.counters().refusal;
    EXPECT_EQ(at(message->header.stamp.toSec()), nullptr);
    EXPECT_NE(why_not_.find(what), std::string::npos) << why_not_;
  }

  MeshMailbox mailbox_{"cloth"};
  MeshInput input_{"cloth", kLimits};
  std::string why_not_;
};

TEST_F(MeshInputTest, NothingYet) {
  EXPECT_EQ(at(50), nullptr);
  EXPECT_EQ(why_not_, "no mesh yet");
}

TEST_F(MeshInputTest, WhatCameAsNoMeshIsRefusedWithItsReason) {
  give(keyframe(50));
  EXPECT_NE(at(50), nullptr);
  mailbox_.store(mesh(50.1), "too large");
  EXPECT_EQ(input_.accept(*mailbox_.take(), kNow), Acceptance::kRefused);
  EXPECT_EQ(at(50.1), nullptr);
  EXPECT_EQ(why_not_, "mesh refused: too large");
  EXPECT_EQ(give(mesh(50.2)), Acceptance::kAccepted) << "the triangles stay known";
}

TEST_F(MeshInputTest, AKeyframeAndWhatRefersToIt) {
  EXPECT_EQ(Acceptance::kAccepted, give(keyframe(50)));
  const auto topology = at(50)->topology;
  EXPECT_EQ(Acceptance::kAccepted, give(mesh(50.1)));
  ASSERT_NE(at(50.1), nullptr);
  EXPECT_EQ(at(50.1)->stamp(), ros::Time(50.1));
  EXPECT_EQ(at(50.1)->topology, topology);
  EXPECT_EQ(topology->triangles, (std::vector<std::uint32_t>{0, 1, 2}));
}

TEST_F(MeshInputTest, TheSameTrianglesAgainAreNoChange) {
  give(keyframe(50));
  const auto topology = at(50)->topology;
  give(keyframe(50.1));
  EXPECT_EQ(at(50.1)->topology, topology);
  EXPECT_EQ(input_.counters().topology_changes, 0U);
}

TEST_F(MeshInputTest, OtherTrianglesAreAChangeEvenUnderTheSameId) {
  give(keyframe(50));
  give(keyframe(50.1, 1, {1, 2, 3}));
  EXPECT_EQ(at(50.1)->topology->triangles, (std::vector<std::uint32_t>{1, 2, 3}));
  give(keyframe(50.2, 2, {0, 2, 3}));
  EXPECT_EQ(at(50.2)->topology->id, 2U);
  EXPECT_EQ(input_.counters().topology_changes, 2U);
}

TEST_F(MeshInputTest, TrianglesOfADroppedMessageAreLearned) {
  mailbox_.store(keyframe(50));
  EXPECT_EQ(Acceptance::kAccepted, give(mesh(50.1)));
  ASSERT_NE(at(50.1), nullptr);
  EXPECT_EQ(at(50.1)->topology->triangles.size(), 3U);
}

TEST_F(MeshInputTest, UnseenTopologyIsRefused) {
  expectRefused(mesh(50), "no triangles of topology_id 1 seen yet");
  give(keyframe(50.1));
  ASSERT_NE(at(50.1), nullptr);
  expectRefused(mesh(50.2, 2), "topology_id 2");
}

TEST_F(MeshInputTest, ARefusedMeshHidesOlderOnes) {
  give(keyframe(50));
  expectRefused(mesh(50.1, 9), "topology_id 9");
  EXPECT_EQ(at(50), nullptr);
  give(mesh(50.2));
  EXPECT_NE(at(50.2), nullptr);
}

TEST_F(MeshInputTest, MalformedMeshesAreRefused) {
  expectRefused(keyframe(50, 1, {0, 1, 4}), "refers to vertex 4");
  expectRefused(keyframe(50, 1, {0, 1, 0xFFFFFFFFU}), "refers to vertex 4294967295");
  expectRefused(keyframe(50, 1, {0, 1}), "multiple of 3");
  auto ragged = keyframe(50);
  ragged->vertices.pop_back();
  expectRefused(ragged, "multiple of 3");
  give(keyframe(50.1));
  auto short_one = mesh(50.2);
  short_one->vertices.resize(9);
  expectRefused(short_one, "has 4 vertices");
  auto empty = mesh(50.3);
  empty->vertices.clear();
  expectRefused(empty, "has 4 vertices");
}

TEST_F(MeshInputTest, AfterBadTrianglesTheOldOnesAreNotUsed) {
  give(keyframe(50));
  expectRefused(keyframe(50.1, 1, {0, 1, 9}), "refers to vertex 9");
  expectRefused(mesh(50.2), "refers to vertex 9");
  give(keyframe(50.3));
  EXPECT_NE(at(50.3), nullptr);
}

// And no longer under its id once that has good ones.
TEST_F(MeshInputTest, TheReasonOfBadTrianglesIsThatOfTheirIdAlone) {
  expectRefused(keyframe(50, 1, {0, 1, 9}), "refers to vertex 9");
  expectRefused(mesh(50.1, 2), "no triangles of topology_id 2 seen yet");
  EXPECT_EQ(input_.counters().refusal.find("vertex 9"), std::string::npos);
  expectRefused(mesh(50.2, 1), "refers to vertex 9");
  give(keyframe(50.3, 2));
  expectRefused(mesh(50.4, 1), "no triangles of topology_id 1 seen yet");
}

TEST_F(MeshInputTest, SenselessHeadersAreRefused) {
  auto nameless = keyframe(50);
  nameless->header.frame_id.clear();
  expectRefused(nameless, "frame_id is empty");
  expectRefused(keyframe(0), "stamp is zero");
  expectRefused(keyframe(51.5), "ahead of this machine's clock");
  auto other = keyframe(50);
  other->object = "cable";
  expectRefused(other, "object 'cable'");
}

TEST_F(MeshInputTest, AnotherObjectsTrianglesAreNotLearned) {
  auto other = keyframe(50);
  other->object = "cable";
  mailbox_.store(other);
  give(mesh(50.1));
  EXPECT_EQ(at(50.1), nullptr);
}

TEST_F(MeshInputTest, NoClockYetMeansNoFuture) {
  input_.accept({keyframe(51.5), keyframe(51.5), {}}, ros::Time());
  EXPECT_TRUE(input_.counters().refusal.empty());
}

TEST_F(MeshInputTest, NonFiniteVerticesAreNoReasonToRefuse) {
  auto message = keyframe(50);
  message->vertices[0] = std::numeric_limits<float>::quiet_NaN();
  give(message);
  EXPECT_NE(at(50), nullptr);
}

TEST_F(MeshInputTest, TheNewestAtOrBeforeAndNotTooOld) {
  give(keyframe(50));
  give(mesh(50.2));
  give(mesh(50.4));
  EXPECT_EQ(at(50.3)->stamp(), ros::Time(50.2));
  EXPECT_EQ(at(50.4)->stamp(), ros::Time(50.4));
  EXPECT_EQ(at(50.9)->stamp(), ros::Time(50.4)) << "max_age_s is closed";
  EXPECT_EQ(at(50.91), nullptr);
  EXPECT_NE(why_not_.find("s old"), std::string::npos) << why_not_;
  EXPECT_EQ(at(49.9), nullptr);
}

TEST_F(MeshInputTest, OutOfOrderIsDropped) {
  give(keyframe(50));
  EXPECT_EQ(give(mesh(49.9)), Acceptance::kDropped);
  EXPECT_EQ(input_.counters().dropped, 1U);
  EXPECT_NE(at(50), nullptr);
}

TEST_F(MeshInputTest, AMeshWithTheStampOfTheNewestReplacesIt) {
  give(keyframe(50));
  auto again = mesh(50);
  again->vertices[0] = 7;
  EXPECT_EQ(give(again), Acceptance::kAccepted);
  EXPECT_EQ(at(50)->message, again);
  EXPECT_EQ(input_.newestAt(ros::Time(50.4), &why_not_)->message, again);
}

TEST_F(MeshInputTest, MeshesOfOneStampTakeNoOthersPlace) {
  give(keyframe(50));
  for (int i = 0; i < 100; ++i) give(mesh(50.1));
  ASSERT_NE(at(50.05), nullptr) << "only 32 are kept";
  EXPECT_EQ(at(50.05)->stamp(), ros::Time(50));
}

// Without a clock, or where the newest was stamped ahead of it.
TEST_F(MeshInputTest, StampsThatGoFarBackForgetWhatWasBefore) {
  give(keyframe(50), ros::Time());
  EXPECT_EQ(give(mesh(49.5), ros::Time()), Acceptance::kDropped) << "max_age_s is closed";
  EXPECT_EQ(give(mesh(49.4), ros::Time()), Acceptance::kJumped);
  EXPECT_EQ(input_.counters().jumps, 1U);
  ASSERT_NE(at(49.8), nullptr) << "triangles outlive a time jump";
  EXPECT_EQ(at(49.8)->stamp(), ros::Time(49.4));
  EXPECT_EQ(give(mesh(51.2)), Acceptance::kAccepted);
  EXPECT_EQ(give(mesh(50.2)), Acceptance::kJumped);
}

// A publisher far behind beside a good one, and messages that are refused.
TEST_F(MeshInputTest, WhatIsRefusedIsNoJump) {
  give(keyframe(50));
  auto nameless = mesh(40);
  nameless->header.frame_id.clear();
  EXPECT_EQ(give(nameless), Acceptance::kRefused);
  EXPECT_EQ(input_.counters().jumps, 0U);
  give(mesh(50.1));
  EXPECT_EQ(give(mesh(49.5)), Acceptance::kDropped) << "too old, and the newest is not";
  EXPECT_EQ(input_.counters().jumps, 0U);
  EXPECT_NE(at(50.1), nullptr);
}

TEST_F(MeshInputTest, WhatIsTooOldIsRefusedUnlessThereIsBetter) {
  expectRefused(keyframe(49.7), "header.stamp is 0.550000 s old");
  EXPECT_NE(why_not_.find("max_mesh_age_s"), std::string::npos) << why_not_;
  EXPECT_NE(why_not_.find("use_sim_time"), std::string::npos) << why_not_;
  EXPECT_EQ(give(mesh(49.75)), Acceptance::kAccepted) << "max_age_s is closed";
  EXPECT_EQ(give(mesh(49.9), ros::Time(60)), Acceptance::kRefused);
  EXPECT_EQ(give(mesh(40), ros::Time()), Acceptance::kAccepted) << "without a clock nothing is";
}

// Such differences do not fit into a ros::Duration.
TEST_F(MeshInputTest, StampsAtTheEndsOfTimeAreSurvived) {
  MeshInput input("cloth", kLimits);
  for (const double stamp_s : {4e9, 1.0, 4.2e9}) {
    EXPECT_NO_THROW(input.accept({keyframe(stamp_s), keyframe(stamp_s), {}}, ros::Time()));
    EXPECT_NO_THROW(input.newestAt(ros::Time(4.2e9), &why_not_));
    EXPECT_NO_THROW(input.newestAt(ros::Time(1), &why_not_));
  }
  expectRefused(keyframe(4e9), "ahead of this machine's clock");
}

TEST_F(MeshInputTest, HistoryIsBoundedInNumberAndBytes) {
  const auto oldestOf = [this](const MeshLimits& limits) {
    MeshInput input("cloth", limits);
    for (int i = 0; i < 100; ++i) {
      const auto message = keyframe(50 + 1e-3 * i);
      input.accept({message, message, {}}, kNow);
    }
    EXPECT_NE(input.newestAt(ros::Time(50.099), &why_not_), nullptr);
    int i = 99;
    while (i >= 0 && input.newestAt(ros::Time(50 + 1e-3 * i), &why_not_) != nullptr) --i;
    return i + 1;
  };
  EXPECT_EQ(oldestOf({60, 1U << 20U}), 68) << "32 of them";
  EXPECT_EQ(oldestOf({60, 10 * (4 * 12 + 4 * 3)}), 90) << "ten meshes of 60 bytes";
  EXPECT_EQ(oldestOf({60, 0}), 99) << "the newest is always kept";
}

}  // namespace
}  // namespace deformable_contact_monitor
