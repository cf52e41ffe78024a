// Tests of the lines and of the separate points that messages become.
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "adapter_checks.h"

namespace deformable_contact_monitor {
namespace {

using geometry_msgs::PoseArray;
using sensor_msgs::PointCloud2;
using visualization_msgs::Marker;
using Indices = std::vector<std::uint32_t>;

using CloudLine = PointsAdapter<PointCloud2>;
using PoseLine = PointsAdapter<PoseArray>;

TriangleMesh nodes(std::size_t count) {
  TriangleMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    mesh.vertices.insert(mesh.vertices.end(), {static_cast<float>(i), 0.5F, 0});
  }
  return mesh;
}

TEST(PointsAdapter, TrianglesAreDegenerate) {
  EXPECT_EQ(trianglesBetween(PointShape::kTriangles, 6), (Indices{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(trianglesBetween(PointShape::kLine, 4), (Indices{0, 1, 1, 1, 2, 2, 2, 3, 3}));
  EXPECT_EQ(trianglesBetween(PointShape::kLine, 2), (Indices{0, 1, 1}));
  EXPECT_EQ(trianglesBetween(PointShape::kLine, 1), (Indices{0, 0, 0})) << "a point";
  EXPECT_EQ(trianglesBetween(PointShape::kSeparate, 3), (Indices{0, 0, 0, 1, 1, 1, 2, 2, 2}));
  for (const PointShape shape :
       {PointShape::kTriangles, PointShape::kLine, PointShape::kSeparate}) {
    EXPECT_TRUE(trianglesBetween(shape, 0).empty());
  }
}

// Also points that are NaN or infinite, whose segments are rejected later.
TEST(PointsAdapter, EachMessageHasThePointsThatWereSent) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    const TriangleMesh mesh = randomMesh(&random);
    CloudLayout layout;
    layout.height = i % 2 == 0 ? 1 : 3;
    layout.row_padding = i % 7;
    const auto expect = [&](const IncomingMesh& adapted, PointShape shape,
                            const std_msgs::Header& header) {
      EXPECT_EQ(bitsOf(adapted.message->vertices), bitsOf(mesh.vertices));
      EXPECT_EQ(adapted.message->triangles, trianglesBetween(shape, mesh.vertexCount()));
      EXPECT_EQ(adapted.message->header, header);
      EXPECT_FALSE(adapted.stamped_on_receipt);
    };
    const PointCloud2 cloud = asPointCloud(mesh, layout);
    for (const PointShape shape : {PointShape::kLine, PointShape::kSeparate}) {
      expect(CloudLine(shape).adapt(cloud, kReceived), shape, cloud.header);
    }
    const PoseArray poses = asPoseArray(mesh);
    expect(PoseLine(PointShape::kLine).adapt(poses, kReceived), PointShape::kLine, poses.header);
    const Marker marker = asLineStrip(mesh);
    expect(MarkerAdapter(PointShape::kLine).adapt(marker, kReceived), PointShape::kLine,
           marker.header);
#ifdef DCM_HAS_NAV_MSGS
    const nav_msgs::Path path = asPath(mesh);
    expect(PointsAdapter<nav_msgs::Path>(PointShape::kLine).adapt(path, kReceived),
           PointShape::kLine, path.header);
#endif
  }
}

// Two lines may have as many triangles and not as many points: of 1 and of 2.
TEST(PointsAdapter, AnotherNumberOfPointsIsAnotherTopology) {
  for (const PointShape shape : {PointShape::kLine, PointShape::kSeparate}) {
    CloudLine adapter(shape);
    Accepting input;
    const auto accept = [&](std::size_t count) {
      return input.accept(adapter.adapt(asPointCloud(nodes(count)), kReceived));
    };
    const auto first = accept(4);
    EXPECT_EQ(accept(4), first);
    for (const std::size_t count : {1U, 2U, 1U, 7U, 4U}) {
      const auto topology = accept(count);
      EXPECT_EQ(topology->vertex_count, count);
      EXPECT_EQ(topology->triangles, trianglesBetween(shape, count));
    }
    EXPECT_EQ(accept(4)->id, first->id);
  }
}

TEST(PointsAdapter, AMessageWithoutPointsIsRefused) {
  const std::string why = "the message has no points";
  for (const PointShape shape : {PointShape::kLine, PointShape::kSeparate}) {
    PointCloud2 cloud = asPointCloud(nodes(0));
    EXPECT_EQ(refusalOf(CloudLine(shape), cloud), why);
    cloud.height = ~0U;
    EXPECT_EQ(refusalOf(CloudLine(shape), cloud), why);
  }
  EXPECT_EQ(refusalOf(PoseLine(PointShape::kLine), PoseArray()), why);
#ifdef DCM_HAS_NAV_MSGS
  EXPECT_EQ(refusalOf(PointsAdapter<nav_msgs::Path>(PointShape::kLine), nav_msgs::Path()), why);
#endif
}

TEST(PointsAdapter, ARefusedMessageLeavesTheAdapterAsItWas) {
  CloudLine adapter(PointShape::kLine);
  EXPECT_FALSE(adapter.adapt(asPointCloud(nodes(3)), kReceived).message->triangles.empty());
  PointCloud2 bad = asPointCloud(nodes(5));
  bad.fields.pop_back();
  EXPECT_NE(refusalOf(adapter, bad), "");
  EXPECT_TRUE(adapter.adapt(asPointCloud(nodes(3)), kReceived).message->triangles.empty());
}

TEST(PointsAdapter, SizesAreCheckedBeforeMemoryIsTaken) {
  const PointCloud2 good = asPointCloud(nodes(9));
  const auto refusal = [&](void (*spoil)(PointCloud2*)) {
    PointCloud2 cloud = good;
    spoil(&cloud);
    return refusalOf(CloudLine(PointShape::kSeparate), cloud);
  };
  EXPECT_EQ(refusal([](PointCloud2*) {}), "");
  expectIn("a row has 51539607540 bytes", refusal([](PointCloud2* c) { c->width = ~0U; }));
  expectIn("row_step x height is 463856467860", refusal([](PointCloud2* c) { c->height = ~0U; }));
  expectIn("point_step is 4, too few bytes for x, y and z", refusal([](PointCloud2* c) {
             for (auto& field : c->fields) field.offset = 0;
             c->point_step = 4;
             c->width = c->row_step / 4;
           }));
}

// rviz draws it the same way: the scale is the line's width.
TEST(PointsAdapter, AMarkersScaleIsNoScaleOfALine) {
  Marker marker = asLineStrip(nodes(3));
  marker.pose.position.x = 10;
  marker.scale.x = marker.scale.z = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(MarkerAdapter(PointShape::kLine).adapt(marker, kReceived).message->vertices,
            (std::vector<float>{10, 0.5F, 0, 11, 0.5F, 0, 12, 0.5F, 0}));
}

TEST(PointsAdapter, AMarkerThatIsNoLineIsRefusedByName) {
  const auto refusal = [](const Marker& marker) {
    return refusalOf(MarkerAdapter(PointShape::kLine), marker);
  };
  Marker marker = asLineStrip(nodes(1));
  EXPECT_EQ(refusal(marker), "") << "a line of one point";
  marker.points.clear();
  EXPECT_EQ(refusal(marker), "the marker has no points");
  marker = asMarker(square());
  EXPECT_EQ(refusal(marker), "the marker's type is 11, not LINE_STRIP (4)");
  marker = asLineStrip(nodes(2));
  marker.action = Marker::DELETE;
  expectIn("was deleted", refusal(marker));
}

#ifdef DCM_HAS_NAV_MSGS
TEST(PointsAdapter, APathWithAPoseInAnotherFrameIsRefused) {
  nav_msgs::Path path = asPath(nodes(4));
  path.poses[2].header.frame_id = "map";
  EXPECT_EQ(refusalOf(PointsAdapter<nav_msgs::Path>(PointShape::kLine), path),
            "pose 2 is in frame 'map', but the path is in 'camera'");
}
#endif

}  // namespace
}  // namespace deformable_contact_monitor
