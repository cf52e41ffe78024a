// Tests of the triangles that polygons of pcl_msgs become.
#include "monitor/input/mesh_adapters.h"

#ifdef DCM_HAS_PCL_MSGS

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "adapter_checks.h"

namespace deformable_contact_monitor {
namespace {

using Indices = std::vector<std::uint32_t>;

TEST(PolygonMeshAdapter, AMeshOfTrianglesIsTheSame) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const TriangleMesh mesh = randomMesh(&random);
    pcl_msgs::PolygonMesh message = asPolygonMesh(mesh);
    message.cloud.header = std_msgs::Header();  // the message's own header counts
    const IncomingMesh adapted = PolygonMeshAdapter().adapt(message, kReceived);
    expectSame(*adapted.message, mesh);
    EXPECT_EQ(adapted.message->header, message.header);
    EXPECT_FALSE(adapted.stamped_on_receipt);
  }
}

TEST(PolygonMeshAdapter, PolygonsAreFannedFromTheirFirstVertex) {
  pcl_msgs::PolygonMesh message = asPolygonMesh(square());
  message.polygons.resize(3);
  message.polygons[0].vertices = {2, 0, 1, 3};
  message.polygons[1].vertices = {0, 1, 2};
  message.polygons[2].vertices = {3, 2, 1, 0, 3};
  EXPECT_EQ(PolygonMeshAdapter().adapt(message, kReceived).message->triangles,
            (Indices{2, 0, 1, 2, 1, 3, 0, 1, 2, 3, 2, 1, 3, 1, 0, 3, 0, 3}));
}

TEST(PolygonMeshAdapter, OtherTrianglesOrPointsAreAnotherTopology) {
  PolygonMeshAdapter adapter;
  Accepting input;
  TriangleMesh moved = square(), other = square(), longer = square();
  moved.vertices[2] = 5;
  std::swap(other.triangles[0], other.triangles[1]);
  longer.vertices.insert(longer.vertices.end(), {7, 7, 7});
  const auto accept = [&](const TriangleMesh& mesh) {
    return input.accept(adapter.adapt(asPolygonMesh(mesh), kReceived));
  };
  const auto first = accept(square());
  EXPECT_EQ(accept(moved), first);
  EXPECT_EQ(accept(other)->triangles, Indices(other.triangles.begin(), other.triangles.end()));
  EXPECT_EQ(accept(square())->triangles, first->triangles);
  EXPECT_EQ(accept(longer)->vertex_count, 5U);
}

TEST(PolygonMeshAdapter, WhatIsNoMeshIsRefusedByName) {
  pcl_msgs::PolygonMesh message = asPolygonMesh(square());
  message.polygons[1].vertices.pop_back();
  EXPECT_EQ(refusalOf(PolygonMeshAdapter(), message),
            "polygon 1 has 2 vertices, must have at least 3");
  message.polygons.clear();
  EXPECT_EQ(refusalOf(PolygonMeshAdapter(), message), "the mesh has no polygon");
  message = asPolygonMesh(square());
  message.cloud.width = 5;
  expectIn("row_step is 48, but a row has 60 bytes", refusalOf(PolygonMeshAdapter(), message));
  message = asPolygonMesh(square());
  message.polygons[0].vertices[2] = 4;
  MeshInput input("cloth", MeshLimits());
  IncomingMesh mesh = PolygonMeshAdapter().adapt(message, kReceived);
  input.store(mesh);
  EXPECT_EQ(input.take(ros::Time(), &mesh), Acceptance::kRejected);
  expectIn("refers to vertex 4, but there are 4", mesh.problem);
}

}  // namespace
}  // namespace deformable_contact_monitor

#endif
