// Tests of which meshes an input stores, accepts, rejects, drops and keeps.
#include "monitor/input/mesh_input.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <utility>
#include <vector>

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

// Tests how meshes arrive: the newest one waits until the detection thread takes it.
class ArrivalTest : public ::testing::Test {
 protected:
  // Takes the mesh that waits, without a clock.
  IncomingMesh take() {
    IncomingMesh mesh;
    EXPECT_NE(input_.take(ros::Time(), &mesh), Acceptance::kNothing);
    return mesh;
  }
  static bool always(const ros::Time& /*stamp*/) { return true; }

  MeshInput input_{"cloth", kLimits};
};

TEST_F(ArrivalTest, NothingWaitsAtFirst) {
  IncomingMesh mesh;
  EXPECT_FALSE(input_.hasWaiting());
  EXPECT_EQ(input_.take(kNow, &mesh), Acceptance::kNothing);
  input_.dropIf(always);
  EXPECT_EQ(input_.counters().dropped, 0U);
}

TEST_F(ArrivalTest, AMeshIsTakenOnce) {
  IncomingMesh stored{keyframe(50)};
  stored.arrival = SteadyTime(std::chrono::hours(7));
  input_.store(stored);
  EXPECT_TRUE(input_.hasWaiting());
  const IncomingMesh taken = take();
  EXPECT_EQ(taken.message, stored.message);
  EXPECT_EQ(taken.arrival, stored.arrival);
  ASSERT_NE(taken.topology, nullptr);
  EXPECT_EQ(taken.topology->triangles, stored.message->triangles);
  EXPECT_FALSE(input_.hasWaiting());
}

// A publisher in the same process may send one message again and again, each time filled anew.
TEST_F(ArrivalTest, AMessageThatChangedAfterItCameIsRejected) {
  const auto message = keyframe(50);
  input_.store({message});
  EXPECT_EQ(take().problem, "");
  input_.store({message});
  EXPECT_EQ(take().problem, "") << "it is as it was";
  for (int i = 1; i < 4; ++i) {
    message->header.stamp += ros::Duration(0.1);
    message->vertices[2] += 1;
    input_.store({message});
    EXPECT_NE(take().problem.find("changed a mesh that it had published"), std::string::npos) << i;
    std::string why_not;
    EXPECT_EQ(input_.newestAt(ros::Time(50 + 0.1 * i), &why_not), nullptr) << i;
  }
  input_.store({keyframe(51)});
  EXPECT_EQ(take().problem, "");
}

TEST_F(ArrivalTest, ADeletionCountsWhenItsGraceEndsUnlessAMeshComesBefore) {
  const auto deletion = [](int ms) {
    IncomingMesh mesh{boost::make_shared<DeformableMesh>(), "it was deleted"};
    mesh.is_deletion = true;
    mesh.arrival = SteadyTime(std::chrono::milliseconds(ms));
    return mesh;
  };
  std::string why_not;
  input_.store({keyframe(50)});
  input_.store(deletion(1000));
  EXPECT_EQ(take().message->header.stamp, ros::Time(50)) << "what came before has its cycle";
  EXPECT_FALSE(input_.hasWaiting());
  EXPECT_EQ(input_.deletedAt(), SteadyTime(std::chrono::milliseconds(1000)));
  EXPECT_NE(input_.newestAt(ros::Time(50.1), &why_not), nullptr);
  input_.store(deletion(1100));
  EXPECT_EQ(input_.deletedAt(), SteadyTime(std::chrono::milliseconds(1000))) << "the first counts";
  input_.store({mesh(50.1)});
  EXPECT_FALSE(input_.deletedAt());
  input_.endGrace();
  EXPECT_EQ(take().message->header.stamp, ros::Time(50.1));
  EXPECT_EQ(input_.counters().rejected, 0U);
  EXPECT_EQ(input_.counters().dropped, 0U);

  input_.store(deletion(2000));
  input_.endGrace();
  IncomingMesh taken;
  EXPECT_EQ(input_.take(kNow, &taken), Acceptance::kRejected);
  EXPECT_EQ(input_.newestAt(ros::Time(50.1), &why_not), nullptr);
  EXPECT_EQ(why_not, "mesh refused: it was deleted");
}

TEST_F(ArrivalTest, ADeletionThatIsUnwantedCountsAtOnce) {
  std::string why_not;
  input_.store({keyframe(50)});
  take();
  IncomingMesh deletion{mesh(0), "it was deleted"};
  deletion.is_deletion = true;
  input_.store(deletion);
  input_.dropIf([](const ros::Time&) { return false; });
  EXPECT_TRUE(input_.deletedAt());
  input_.dropIf(always);
  EXPECT_FALSE(input_.deletedAt());
  EXPECT_EQ(input_.newestAt(ros::Time(50.1), &why_not), nullptr);
}

TEST_F(ArrivalTest, TheNewestWaitsOlderOnesAreDroppedAndCounted) {
  for (const double stamp_s : {50.0, 50.1, 50.2}) input_.store({mesh(stamp_s)});
  EXPECT_TRUE(input_.hasWaiting());
  EXPECT_EQ(input_.counters().received, 3U);
  EXPECT_EQ(input_.counters().dropped, 2U);
  EXPECT_EQ(take().stamp(), ros::Time(50.2));
}

TEST_F(ArrivalTest, MeshesThatAreDroppedLaterAreCountedToo) {
  input_.store({keyframe(50), "", true});
  take();
  input_.countDropped();
  EXPECT_EQ(input_.counters().dropped, 1U);
  EXPECT_EQ(input_.counters().stamped_on_receipt, 1U);
}

TEST_F(ArrivalTest, TrianglesOfADroppedMessageAreKept) {
  input_.store({keyframe(50)});
  input_.store({mesh(50.1)});
  input_.dropIf(always);
  input_.store({mesh(50.2)});
  const auto topology = take().topology;
  ASSERT_NE(topology, nullptr);
  EXPECT_EQ(topology->triangles, (std::vector<std::uint32_t>{0, 1, 2}));
  input_.store({mesh(50.3)});
  EXPECT_EQ(take().topology, topology);
}

TEST_F(ArrivalTest, AnotherObjectsTrianglesReplaceNone) {
  input_.store({keyframe(50)});
  auto other = keyframe(50.1, 1, {2, 1, 0});
  other->object = "cable";
  input_.store({other});
  input_.store({mesh(50.2)});
  EXPECT_EQ(take().topology->triangles, (std::vector<std::uint32_t>{0, 1, 2}));
}

TEST_F(ArrivalTest, OfferedTrianglesAreUsedUnlessTheMeshHasItsOwn) {
  input_.storeTriangles(keyframe(50, 1, {2, 1, 0}));
  input_.storeTriangles(nullptr);
  input_.store({mesh(50.1)});
  EXPECT_EQ(take().topology->triangles, (std::vector<std::uint32_t>{2, 1, 0}));
  input_.storeTriangles(keyframe(50, 1, {2, 1, 0}));
  input_.store({keyframe(50.2)});
  EXPECT_EQ(take().topology->triangles, (std::vector<std::uint32_t>{0, 1, 2}));
}

TEST_F(ArrivalTest, OnlyWhatIsUnwantedIsDropped) {
  const auto late = [](const ros::Time& stamp) { return stamp > ros::Time(60); };
  input_.store({mesh(50)});
  input_.dropIf(late);
  EXPECT_TRUE(input_.hasWaiting());
  input_.store({mesh(61)});
  input_.dropIf(late);
  EXPECT_FALSE(input_.hasWaiting());
  EXPECT_EQ(input_.counters().dropped, 2U);
}

// Every mesh that was stored was either taken or counted as dropped, in whatever order threads ran.
TEST_F(ArrivalTest, NoMeshGetsLostBetweenThreads) {
  constexpr int kMeshes = 5000;
  std::thread publisher([this] {
    for (int i = 1; i <= kMeshes; ++i) input_.store({keyframe(i)});
  });
  std::uint64_t taken = 0;
  for (ros::Time last; last != ros::Time(kMeshes);) {
    IncomingMesh mesh;
    if (input_.take(ros::Time(), &mesh) == Acceptance::kNothing) continue;
    EXPECT_GT(mesh.stamp(), last);
    ++taken;
    last = mesh.stamp();
  }
  publisher.join();
  EXPECT_EQ(input_.counters().received, static_cast<std::uint64_t>(kMeshes));
  EXPECT_EQ(taken + input_.counters().dropped, static_cast<std::uint64_t>(kMeshes));
}

class MeshInputTest : public ::testing::Test {
 protected:
  Acceptance give(const DeformableMesh::ConstPtr& message, const ros::Time& now = kNow) {
    IncomingMesh mesh{message};
    input_.store(mesh);
    return input_.take(now, &mesh);
  }

  const IncomingMesh* at(double t_s) { return input_.newestAt(ros::Time(t_s), &why_not_); }

  void expectRejected(const DeformableMesh::ConstPtr& message, const std::string& what) {
    EXPECT_EQ(give(message), Acceptance::kRejected);
    EXPECT_NE(input_.counters().problem.find(what), std::string::npos) << input_.counters().problem;
    EXPECT_EQ(at(message->header.stamp.toSec()), nullptr);
    EXPECT_NE(why_not_.find(what), std::string::npos) << why_not_;
  }

  MeshInput input_{"cloth", kLimits};
  std::string why_not_;
};

TEST_F(MeshInputTest, NothingYet) {
  EXPECT_EQ(at(50), nullptr);
  EXPECT_EQ(why_not_, "no mesh yet");
}

TEST_F(MeshInputTest, AnInvalidMeshIsRejectedWithItsReason) {
  give(keyframe(50));
  EXPECT_NE(at(50), nullptr);
  IncomingMesh damaged{mesh(50.1), "too large"};
  input_.store(damaged);
  EXPECT_EQ(input_.take(kNow, &damaged), Acceptance::kRejected);
  EXPECT_EQ(damaged.topology, nullptr);
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
  input_.store({keyframe(50)});
  EXPECT_EQ(Acceptance::kAccepted, give(mesh(50.1)));
  ASSERT_NE(at(50.1), nullptr);
  EXPECT_EQ(at(50.1)->topology->triangles.size(), 3U);
}

TEST_F(MeshInputTest, UnseenTopologyIsRejected) {
  expectRejected(mesh(50), "no triangles of topology_id 1 seen yet");
  give(keyframe(50.1));
  ASSERT_NE(at(50.1), nullptr);
  expectRejected(mesh(50.2, 2), "topology_id 2");
}

TEST_F(MeshInputTest, ARejectedMeshHidesOlderOnes) {
  give(keyframe(50));
  expectRejected(mesh(50.1, 9), "topology_id 9");
  EXPECT_EQ(at(50), nullptr);
  give(mesh(50.2));
  EXPECT_NE(at(50.2), nullptr);
}

TEST_F(MeshInputTest, MalformedMeshesAreRejected) {
  expectRejected(keyframe(50, 1, {0, 1, 4}), "refers to vertex 4");
  expectRejected(keyframe(50, 1, {0, 1, 0xFFFFFFFFU}), "refers to vertex 4294967295");
  expectRejected(keyframe(50, 1, {0, 1}), "multiple of 3");
  auto ragged = keyframe(50);
  ragged->vertices.pop_back();
  expectRejected(ragged, "multiple of 3");
  give(keyframe(50.1));
  auto short_one = mesh(50.2);
  short_one->vertices.resize(9);
  expectRejected(short_one, "has 4 vertices");
  auto empty = mesh(50.3);
  empty->vertices.clear();
  expectRejected(empty, "has 4 vertices");
}

TEST_F(MeshInputTest, AfterBadTrianglesTheOldOnesAreNotUsed) {
  give(keyframe(50));
  expectRejected(keyframe(50.1, 1, {0, 1, 9}), "refers to vertex 9");
  expectRejected(mesh(50.2), "refers to vertex 9");
  give(keyframe(50.3));
  EXPECT_NE(at(50.3), nullptr);
}

// And no longer under its id once that has good ones.
TEST_F(MeshInputTest, TheReasonOfBadTrianglesIsThatOfTheirIdAlone) {
  expectRejected(keyframe(50, 1, {0, 1, 9}), "refers to vertex 9");
  expectRejected(mesh(50.1, 2), "no triangles of topology_id 2 seen yet");
  EXPECT_EQ(input_.counters().problem.find("vertex 9"), std::string::npos);
  expectRejected(mesh(50.2, 1), "refers to vertex 9");
  give(keyframe(50.3, 2));
  expectRejected(mesh(50.4, 1), "no triangles of topology_id 1 seen yet");
}

TEST_F(MeshInputTest, SenselessHeadersAreRejected) {
  auto nameless = keyframe(50);
  nameless->header.frame_id.clear();
  expectRejected(nameless, "frame_id is empty");
  expectRejected(keyframe(0), "stamp is zero");
  auto overfull = keyframe(49);
  overfull->header.stamp.nsec = 1250000000;
  expectRejected(overfull, "1250000000 ns");
  expectRejected(keyframe(51.5), "ahead of this machine's clock");
  auto other = keyframe(50);
  other->object = "cable";
  expectRejected(other, "object 'cable'");
}

TEST_F(MeshInputTest, AnotherObjectsTrianglesAreNotLearned) {
  auto other = keyframe(50);
  other->object = "cable";
  input_.store({other});
  give(mesh(50.1));
  EXPECT_EQ(at(50.1), nullptr);
}

TEST_F(MeshInputTest, NoClockYetMeansNoFuture) {
  EXPECT_EQ(give(keyframe(51.5), ros::Time()), Acceptance::kAccepted);
  EXPECT_TRUE(input_.counters().problem.empty());
}

TEST_F(MeshInputTest, NonFiniteVerticesAreNoReasonToReject) {
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
TEST_F(MeshInputTest, WhatIsRejectedIsNoJump) {
  give(keyframe(50));
  auto nameless = mesh(40);
  nameless->header.frame_id.clear();
  EXPECT_EQ(give(nameless), Acceptance::kRejected);
  EXPECT_EQ(input_.counters().jumps, 0U);
  give(mesh(50.1));
  EXPECT_EQ(give(mesh(49.5)), Acceptance::kDropped) << "too old, and the newest is not";
  EXPECT_EQ(input_.counters().jumps, 0U);
  EXPECT_NE(at(50.1), nullptr);
}

TEST_F(MeshInputTest, WhatIsTooOldIsRejectedUnlessThereIsBetter) {
  expectRejected(keyframe(49.7), "header.stamp is 0.550000 s old");
  EXPECT_NE(why_not_.find("max_mesh_age_s"), std::string::npos) << why_not_;
  EXPECT_NE(why_not_.find("it came late"), std::string::npos) << why_not_;
  EXPECT_EQ(give(keyframe(29), ros::Time(90)), Acceptance::kRejected);
  EXPECT_NE(input_.counters().problem.find("use_sim_time"), std::string::npos);
  EXPECT_EQ(give(mesh(49.75)), Acceptance::kAccepted) << "max_age_s is closed";
  EXPECT_EQ(give(mesh(49.9), ros::Time(60)), Acceptance::kRejected);
  EXPECT_EQ(give(mesh(40), ros::Time()), Acceptance::kAccepted) << "without a clock nothing is";
}

// Such differences do not fit into a ros::Duration.
TEST_F(MeshInputTest, StampsAtTheEndsOfTimeAreSurvived) {
  expectRejected(keyframe(4e9), "ahead of this machine's clock");
  for (const double stamp_s : {4e9, 1.0, 4.2e9}) {
    EXPECT_NO_THROW(give(keyframe(stamp_s), ros::Time()));
    EXPECT_NO_THROW(at(4.2e9));
    EXPECT_NO_THROW(at(1));
  }
}

TEST_F(MeshInputTest, HistoryIsBoundedInNumberAndBytes) {
  const auto oldestOf = [this](const MeshLimits& limits) {
    MeshInput input("cloth", limits);
    for (int i = 0; i < 100; ++i) {
      IncomingMesh mesh{keyframe(50 + 1e-3 * i)};
      input.store(mesh);
      input.take(kNow, &mesh);
    }
    EXPECT_NE(input.newestAt(ros::Time(50.099), &why_not_), nullptr);
    int i = 99;
    while (i >= 0 && input.newestAt(ros::Time(50 + 1e-3 * i), &why_not_) != nullptr) --i;
    return i + 1;
  };
  EXPECT_EQ(oldestOf({60, 1U << 20U}), 68) << "32 of them";
  EXPECT_EQ(oldestOf({60, 10 * (4 * 12 + 4 * 3)}), 90) << "ten meshes of 60 bytes";
  EXPECT_EQ(oldestOf({60, 0}), 96) << "the newest four are always kept";
}

TEST_F(MeshInputTest, AmongThoseThatAreYoungEnoughAPreferredOneIsChosen) {
  for (const double t_s : {49.0, 49.8, 49.9, 50.0}) give(keyframe(t_s));
  std::vector<double> asked;
  double preferred_s = 49.8;
  const auto stampAt = [&](double t_s) {
    asked.clear();
    const IncomingMesh* const mesh =
        input_.newestAt(ros::Time(t_s), &why_not_, [&](const IncomingMesh& one) {
          asked.push_back(one.stamp().toSec());
          return asked.back() == preferred_s;
        });
    return mesh == nullptr ? 0 : mesh->stamp().toSec();
  };
  EXPECT_EQ(stampAt(50), 49.8);
  EXPECT_EQ(asked, (std::vector<double>{50, 49.9, 49.8}));
  preferred_s = 50;
  EXPECT_EQ(stampAt(50), 50);
  EXPECT_EQ(stampAt(49.95), 49.9) << "none is preferred";
  preferred_s = 49;
  EXPECT_EQ(stampAt(50), 50) << "that one is too old";
  EXPECT_EQ(stampAt(48), 0);
}

}  // namespace
}  // namespace deformable_contact_monitor
