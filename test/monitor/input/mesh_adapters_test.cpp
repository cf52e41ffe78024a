// What messages of other types become, and why some are refused.
#include "monitor/input/mesh_adapters.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "adapter_checks.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;

TriangleMesh soupOf(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const std::uint32_t corner : mesh.triangles) {
    soup.triangles.push_back(static_cast<std::uint32_t>(soup.triangles.size()));
    const auto at = mesh.vertices.begin() + 3 * corner;
    soup.vertices.insert(soup.vertices.end(), at, at + 3);
  }
  return soup;
}

TEST(MeshAdapters, AMeshIsTheSameWhateverItComesAs) {
  std::mt19937 random(1);
  for (int i = 0; i < 500; ++i) {
    const TriangleMesh mesh = randomMesh(&random);
    expectSame(*ShapeMeshAdapter("camera").adapt(asShapeMesh(mesh), kReceived).message, mesh);
    expectSame(*MarkerAdapter().adapt(asMarker(mesh), kReceived).message, soupOf(mesh));
    expectSame(*cloudAdapter(mesh).adapt(asPointCloud(mesh), kReceived).message, mesh);
  }
}

TEST(MeshAdapters, StampAndFrameAreTheMessagesOrThoseOfItsReceipt) {
  const ReceivedMesh shape = ShapeMeshAdapter("table").adapt(asShapeMesh(square()), kReceived);
  EXPECT_EQ(shape.message->header.stamp, kReceived);
  EXPECT_EQ(shape.message->header.frame_id, "table");
  EXPECT_TRUE(shape.stamped_on_receipt);

  Marker unstamped = asMarker(square());
  unstamped.header.stamp = ros::Time();
  MarkerAdapter markers;
  const ReceivedMesh late = markers.adapt(unstamped, kReceived);
  EXPECT_EQ(late.message->header.stamp, kReceived);
  EXPECT_EQ(late.message->header.frame_id, "camera");
  EXPECT_TRUE(late.stamped_on_receipt);
  const ReceivedMesh stamped = markers.adapt(asMarker(square()), kReceived);
  EXPECT_EQ(stamped.message->header.stamp, kSent);
  EXPECT_FALSE(stamped.stamped_on_receipt);

  const ReceivedMesh cloud = cloudAdapter(square()).adapt(asPointCloud(square()), kReceived);
  EXPECT_EQ(cloud.message->header.stamp, kSent);
  EXPECT_EQ(cloud.message->header.frame_id, "camera");
  EXPECT_FALSE(cloud.stamped_on_receipt);
}

TEST(MeshAdapters, WithoutAClockThereIsNoTimeOfReceipt) {
  expectIn("/clock is silent",
           refusalOf(ShapeMeshAdapter("table"), asShapeMesh(square()), ros::Time()));
  Marker unstamped = asMarker(square());
  unstamped.header.stamp = ros::Time();
  expectIn("/clock is silent", refusalOf(MarkerAdapter(), unstamped, ros::Time()));
  EXPECT_EQ(refusalOf(MarkerAdapter(), asMarker(square()), ros::Time()), "");
}

// The C library's reading of a double's exact text is the oracle.
float nearest(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%a", value);
  return std::strtof(text, nullptr);
}

TEST(MeshAdapters, DoublesBecomeTheNearestFloat) {
  std::mt19937_64 random(2);
  std::vector<double> values = {0.1,
                                1 + std::ldexp(1.0, -24),
                                1 + 3 * std::ldexp(1.0, -24),
                                1e39,
                                -1e39,
                                3.4028235677973366e38,
                                1e-46,
                                1e-39};
  for (int i = 0; i < 3000; ++i) {
    const std::uint64_t bits = random();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (i % 2 == 0) value = std::ldexp(1 + std::fmod(std::abs(value), 1.0), i % 300 - 150);
    if (std::isfinite(value)) values.push_back(value);
  }
  values.resize(values.size() / 3 * 3);
  shape_msgs::Mesh message = asShapeMesh(square());
  message.vertices.clear();
  std::vector<float> expected;
  for (std::size_t i = 0; i < values.size(); i += 3) {
    geometry_msgs::Point point;
    point.x = values[i];
    point.y = values[i + 1];
    point.z = values[i + 2];
    message.vertices.push_back(point);
    for (std::size_t axis = 0; axis < 3; ++axis) expected.push_back(nearest(values[i + axis]));
  }
  const ReceivedMesh mesh = ShapeMeshAdapter("camera").adapt(message, kReceived);
  EXPECT_EQ(bitsOf(mesh.message->vertices), bitsOf(expected));
}

// Against Eigen's rotation by quaternion products.
TEST(MeshAdapters, AMarkersPointsAreScaledThenPosed) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    Marker marker = asMarker(square());
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
            .normalized();
    const Eigen::Vector3d t(normal(random), normal(random), normal(random));
    const Eigen::Vector3d scale(normal(random), normal(random), normal(random));
    constexpr double kAlmostUnit = 1.001;  // it is normalized
    marker.pose.orientation.w = kAlmostUnit * q.w();
    marker.pose.orientation.x = kAlmostUnit * q.x();
    marker.pose.orientation.y = kAlmostUnit * q.y();
    marker.pose.orientation.z = kAlmostUnit * q.z();
    marker.pose.position.x = t.x();
    marker.pose.position.y = t.y();
    marker.pose.position.z = t.z();
    marker.scale.x = scale.x();
    marker.scale.y = scale.y();
    marker.scale.z = scale.z();
    for (geometry_msgs::Point& point : marker.points) point.z = normal(random);
    const ReceivedMesh mesh = MarkerAdapter().adapt(marker, kReceived);
    for (std::size_t k = 0; k < marker.points.size(); ++k) {
      const geometry_msgs::Point& p = marker.points[k];
      const Eigen::Quaterniond pure(0, scale.x() * p.x, scale.y() * p.y, scale.z() * p.z);
      const Eigen::Vector3d posed = (q * pure * q.conjugate()).vec() + t;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(mesh.message->vertices[3 * k + axis], posed[axis], 1e-6);
      }
    }
  }
}

TEST(MeshAdapters, AQuarterTurnAndNoOrientation) {
  Marker marker = asMarker({{1, 2, 3, 1, 2, 3, 1, 2, 3}, {0, 1, 2}});
  marker.scale.x = 2;
  const ReceivedMesh unturned = MarkerAdapter().adapt(marker, kReceived);
  EXPECT_EQ(unturned.message->vertices, (std::vector<float>{2, 2, 3, 2, 2, 3, 2, 2, 3}));
  marker.pose.orientation.z = marker.pose.orientation.w = std::sqrt(0.5);
  marker.pose.position.x = 10;
  const ReceivedMesh turned = MarkerAdapter().adapt(marker, kReceived);
  for (std::size_t i = 0; i < 9; i += 3) {
    EXPECT_FLOAT_EQ(turned.message->vertices[i], 8);
    EXPECT_FLOAT_EQ(turned.message->vertices[i + 1], 2);
    EXPECT_FLOAT_EQ(turned.message->vertices[i + 2], 3);
  }
}

TEST(MeshAdapters, AShapeMeshHasANewTopologyIffItsTrianglesChange) {
  ShapeMeshAdapter adapter("camera");
  Accepting input;
  TriangleMesh moved = square(), other = square(), longer = square();
  moved.vertices[2] = 5;
  std::swap(other.triangles[0], other.triangles[1]);
  longer.vertices.insert(longer.vertices.end(), {7, 7, 7});
  const auto accept = [&](const TriangleMesh& mesh) {
    return input.accept(adapter.adapt(asShapeMesh(mesh), kReceived));
  };
  const auto first = accept(square());
  EXPECT_EQ(first->triangles, square().triangles);
  EXPECT_EQ(accept(moved), first);
  EXPECT_TRUE(adapter.adapt(asShapeMesh(moved), kReceived).message->triangles.empty())
      << "the same triangles need not be copied";
  const auto second = accept(other);
  EXPECT_NE(second, first);
  EXPECT_EQ(second->triangles, other.triangles);
  EXPECT_NE(second->id, first->id);
  const auto third = accept(longer);
  EXPECT_EQ(third->vertex_count, 5U);
  EXPECT_EQ(accept(longer), third);
  EXPECT_EQ(accept(square())->triangles, square().triangles);
}

TEST(MeshAdapters, AMarkerHasANewTopologyIffItsCountChanges) {
  MarkerAdapter adapter;
  Accepting input;
  TriangleMesh one = square();
  one.triangles.resize(3);
  const auto accept = [&](const TriangleMesh& mesh) {
    return input.accept(adapter.adapt(asMarker(mesh), kReceived));
  };
  const auto first = accept(square());
  EXPECT_EQ(first->triangles, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(accept(square()), first);
  const auto second = accept(one);
  EXPECT_EQ(second->triangles, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_NE(second->id, first->id);
  EXPECT_EQ(accept(square())->id, first->id);
}

TEST(MeshAdapters, AnIndexOutOfRangeIsRefusedForAsLongAsItComes) {
  ShapeMeshAdapter adapter("camera");
  MeshInput input("cloth", MeshLimits());
  const auto accept = [&](const TriangleMesh& mesh) {
    MeshMailbox mailbox("cloth");
    mailbox.store(adapter.adapt(asShapeMesh(mesh), kReceived));
    return input.accept(*mailbox.take(), ros::Time());
  };
  TriangleMesh bad = square();
  bad.triangles[0] = 4;
  EXPECT_EQ(accept(square()), Acceptance::kAccepted);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(accept(bad), Acceptance::kRefused);
    expectIn("refers to vertex 4, but there are 4", input.counters().refusal);
  }
  EXPECT_EQ(accept(square()), Acceptance::kAccepted);
}

TEST(MeshAdapters, AShapeMeshWithoutTrianglesIsRefused) {
  shape_msgs::Mesh message = asShapeMesh(square());
  message.triangles.clear();
  EXPECT_EQ(refusalOf(ShapeMeshAdapter("camera"), message), "the mesh has no triangle");
}

TEST(MeshAdapters, AMarkerThatIsNoMeshIsRefusedByName) {
  struct Case {
    std::function<void(Marker*)> spoil;
    std::string why;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Case& bad : std::vector<Case>{
           {[](Marker* m) { m->type = Marker::CUBE; }, "type is 1, not TRIANGLE_LIST (11)"},
           {[](Marker* m) { m->action = 1; }, "action is 1, not ADD"},
           {[](Marker* m) { m->action = Marker::DELETE; }, "'cloth'/0 was deleted"},
           {[](Marker* m) { m->action = Marker::DELETEALL; }, "(DELETEALL)"},
           {[](Marker* m) { m->points.pop_back(); }, "5 points, no multiple of 3"},
           {[](Marker* m) { m->points.clear(); }, "no points"},
           {[](Marker* m) { m->scale.y = 0; }, "scale is zero"},
           {[=](Marker* m) { m->scale.y = nan; }, "scale is not finite"},
           {[=](Marker* m) { m->pose.position.z = nan; }, "pose.position is not finite"},
           {[=](Marker* m) { m->pose.orientation.z = nan; }, "no unit quaternion"},
           {[](Marker* m) { m->pose.orientation.z = 2; }, "its length is 2"}}) {
    Marker marker = asMarker(square());
    bad.spoil(&marker);
    expectIn(bad.why, refusalOf(MarkerAdapter(), marker));
  }
}

TEST(MeshAdapters, TheFirstMarkerIsTheObjectUntilItIsDeleted) {
  for (const int action : {Marker::DELETE, Marker::DELETEALL}) {
    Marker arrow = asMarker(square()), first = arrow, other = arrow;
    arrow.type = Marker::ARROW;
    arrow.id = 9;
    other.id = 3;
    MarkerAdapter adapter;
    EXPECT_NE(refusalOf(adapter, arrow), "");
    EXPECT_EQ(refusalOf(adapter, first), "");
    expectIn("it is marker 'cloth'/3, but the object is marker 'cloth'/0",
             refusalOf(adapter, other));
    other.action = Marker::DELETE;
    expectIn("it is marker 'cloth'/3", refusalOf(adapter, other));
    EXPECT_EQ(refusalOf(adapter, first), "");
    first.action = action;
    expectIn("deleted", refusalOf(adapter, first));
    other.action = Marker::ADD;
    EXPECT_EQ(refusalOf(adapter, other), "");
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
