// Tests that triangles hold only for the connections of publishers that sent them.
#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <string>
#include <vector>

#include "monitor/input/mesh_input.h"
#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

using Triangles = std::vector<std::uint32_t>;

const Triangles kHalf = {0, 1, 2}, kOtherHalf = {1, 3, 2};

class MeshConnectionsTest : public ::testing::Test {
 protected:
  using Connection = boost::shared_ptr<const void>;

  static Connection connect() { return boost::make_shared<int>(); }

  // Stores the connection's next mesh of topology_id 1. No triangles: it leaves them out.
  void store(const Connection& connection, const Triangles& triangles = {}) {
    auto message = boost::make_shared<DeformableMesh>();
    stamp_ += ros::Duration(0.01);
    message->header.stamp = stamp_;
    message->header.frame_id = "camera";
    message->topology_id = 1;
    message->vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    message->triangles = triangles;
    IncomingMesh mesh{message};
    mesh.publisher = "/cloth";  // a node that starts anew keeps its name
    mesh.arrival = now_;
    mesh.connection = connection;
    input_.store(mesh);
  }

  // Returns the triangles that the mesh which waits is read with; none: it is rejected.
  Triangles take() {
    IncomingMesh mesh;
    EXPECT_NE(input_.take(ros::Time(), &mesh), Acceptance::kNothing);
    problem_ = mesh.problem;
    return mesh.topology ? mesh.topology->triangles : Triangles();
  }

  Triangles give(const Connection& connection, const Triangles& triangles = {}) {
    store(connection, triangles);
    return take();
  }

  const SteadyTime now_{std::chrono::hours(1)};
  MeshInput input_{"cloth", MeshLimits()};
  ros::Time stamp_{50};
  std::string problem_;
};

TEST_F(MeshConnectionsTest, APublisherThatStartsAnewIsNotReadWithOldTriangles) {
  Connection before = connect();
  EXPECT_EQ(give(before, kHalf), kHalf);
  EXPECT_EQ(give(before), kHalf);
  before.reset();
  const Connection after = connect();
  EXPECT_EQ(give(after), Triangles());
  expectIn("no triangles of topology_id 1 seen from this publisher", problem_);
  EXPECT_EQ(give(after, kOtherHalf), kOtherHalf);
  EXPECT_EQ(give(after), kOtherHalf);
}

TEST_F(MeshConnectionsTest, PublishersThatSentEqualTrianglesTakeTurns) {
  const Connection first = connect(), second = connect();
  give(first, kHalf);
  EXPECT_EQ(give(second), Triangles());
  give(second, kHalf);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(give(first), kHalf);
    EXPECT_EQ(give(second), kHalf);
  }
  EXPECT_EQ(input_.counters().topology_changes, 0U);
}

// The detection thread is busy when all of these arrive.
TEST_F(MeshConnectionsTest, AllThatSentThemBeforeTheNextTakeCount) {
  const Connection first = connect(), second = connect(), third = connect();
  for (const Connection& connection : {first, second}) store(connection, kHalf);
  store(third);
  EXPECT_EQ(take(), Triangles());
  EXPECT_EQ(give(first), kHalf);
  EXPECT_EQ(give(second), kHalf);

  store(first, kHalf);
  store(second, kOtherHalf);
  store(third, kOtherHalf);
  EXPECT_EQ(take(), kOtherHalf);
  EXPECT_EQ(give(second), kOtherHalf);
  EXPECT_EQ(give(first), Triangles());
}

TEST_F(MeshConnectionsTest, TrianglesOfAnotherPublisherReplaceThem) {
  const Connection first = connect(), second = connect();
  give(first, kHalf);
  EXPECT_EQ(give(second, kOtherHalf), kOtherHalf);
  EXPECT_EQ(give(first), Triangles());
  expectIn("since another one sent different ones", problem_);
  EXPECT_EQ(give(second), kOtherHalf);
}

// Adapters name none, and so do publishers in this process where roscpp does not tell.
TEST_F(MeshConnectionsTest, WithoutAConnectionTheIdIsEnough) {
  EXPECT_EQ(give(nullptr, kHalf), kHalf);
  EXPECT_EQ(give(nullptr), kHalf);
  EXPECT_EQ(give(connect()), Triangles()) << "that one has sent none";
}

TEST_F(MeshConnectionsTest, OtherTrianglesUnderTheIdOfTheOldOnesAreReportedForAMoment) {
  const Connection first = connect(), second = connect();
  give(first, kHalf);
  give(first, kHalf);
  give(second, kOtherHalf);
  EXPECT_EQ(input_.rivals(now_), "") << "they are those of another publisher";
  give(second, kHalf);
  expectIn("/cloth changed the triangles and kept topology_id 1", input_.rivals(now_));
  EXPECT_EQ(input_.rivals(now_ + std::chrono::seconds(6)), "");
}

}  // namespace
}  // namespace deformable_contact_monitor
