// Tests of the meshes that messages of other types become, and of why some are rejected.
#include "monitor/input/mesh_adapters.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
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
  const IncomingMesh shape = ShapeMeshAdapter("table").adapt(asShapeMesh(square()), kReceived);
  EXPECT_EQ(shape.message->header.stamp, kReceived);
  EXPECT_EQ(shape.message->header.frame_id, "table");
  EXPECT_TRUE(shape.stamped_on_receipt);

  Marker unstamped = asMarker(square());
  unstamped.header.stamp = ros::Time();
  MarkerAdapter markers;
  const IncomingMesh late = markers.adapt(unstamped, kReceived);
  EXPECT_EQ(late.message->header.stamp, kReceived);
  EXPECT_EQ(late.message->header.frame_id, "camera");
  EXPECT_TRUE(late.stamped_on_receipt);
  const IncomingMesh stamped = markers.adapt(asMarker(square()), kReceived);
  EXPECT_EQ(stamped.message->header.stamp, kSent);
  EXPECT_FALSE(stamped.stamped_on_receipt);

  const IncomingMesh cloud = cloudAdapter(square()).adapt(asPointCloud(square()), kReceived);
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

// The oracle prints a double exactly, and lets the C library read the text as a float32.
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
  const IncomingMesh mesh = ShapeMeshAdapter("camera").adapt(message, kReceived);
  EXPECT_EQ(bitsOf(mesh.message->vertices), bitsOf(expected));
}

// Compares with Eigen's rotation, which uses quaternion products.
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
    const IncomingMesh mesh = MarkerAdapter().adapt(marker, kReceived);
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
  const IncomingMesh unturned = MarkerAdapter().adapt(marker, kReceived);
  EXPECT_EQ(unturned.message->vertices, (std::vector<float>{2, 2, 3, 2, 2, 3, 2, 2, 3}));
  marker.pose.orientation.z = marker.pose.orientation.w = std::sqrt(0.5);
  marker.pose.position.x = 10;
  const IncomingMesh turned = MarkerAdapter().adapt(marker, kReceived);
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
    IncomingMesh adapted = adapter.adapt(asShapeMesh(mesh), kReceived);
    input.store(adapted);
    return input.take(ros::Time(), &adapted);
  };
  TriangleMesh bad = square();
  bad.triangles[0] = 4;
  EXPECT_EQ(accept(square()), Acceptance::kAccepted);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(accept(bad), Acceptance::kRejected);
    expectIn("refers to vertex 4, but there are 4", input.counters().problem);
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
    EXPECT_TRUE(MarkerAdapter(adapter).adapt(first, kReceived).is_deletion);
    expectIn("deleted", refusalOf(adapter, first));
    other.action = Marker::ADD;
    EXPECT_EQ(refusalOf(adapter, other), "");
  }
}

TEST(PointCloudAdapter, ACloudHasOneTopology) {
  PointCloudAdapter adapter = cloudAdapter(square());
  Accepting input;
  const auto accept = [&] {
    return input.accept(adapter.adapt(asPointCloud(square()), kReceived));
  };
  const auto first = accept();
  EXPECT_EQ(first->triangles, square().triangles);
  EXPECT_EQ(accept(), first);
  EXPECT_TRUE(adapter.adapt(asPointCloud(square()), kReceived).message->triangles.empty());
}

// Coordinates may lie anywhere within a point, in either precision, with gaps between points and
// rows.
TEST(PointCloudAdapter, ACloudsLayoutIsItsOwnMatter) {
  std::mt19937 random(4);
  for (int i = 0; i < 500; ++i) {
    const TriangleMesh mesh = randomMesh(&random);
    CloudLayout layout;
    std::uint32_t end = 0;
    for (const int axis : i % 2 == 0 ? std::vector<int>{0, 1, 2} : std::vector<int>{2, 0, 1}) {
      layout.is_double[axis] = random() % 2 == 0;
      layout.offsets[axis] = end + random() % 5;
      end = layout.offsets[axis] + (layout.is_double[axis] ? 8 : 4);
    }
    layout.point_step = end + random() % 7;
    layout.row_padding = random() % 9;
    layout.height = random() % 2 == 0 ? 3 : 1;
    sensor_msgs::PointCloud2 cloud = asPointCloud(mesh, layout);
    sensor_msgs::PointField color;
    color.name = "rgb";
    color.datatype = sensor_msgs::PointField::UINT32;
    color.count = 1;
    cloud.fields.insert(cloud.fields.begin(), color);
    expectSame(*cloudAdapter(mesh).adapt(cloud, kReceived).message, mesh);
  }
}

TEST(PointCloudAdapter, ACloudOfABadLayoutIsRefusedByName) {
  using Cloud = sensor_msgs::PointCloud2;
  struct Case {
    std::function<void(Cloud*)> spoil;
    std::string why;
  };
  for (const Case& bad : std::vector<Case>{
           {[](Cloud* c) { c->is_bigendian = 1; }, "big-endian"},
           {[](Cloud* c) { c->width = 5; }, "5 x 1 points, but its faces are of 4 vertices"},
           {[](Cloud* c) { c->width = c->height = 0; }, "0 x 0 points"},
           {[](Cloud* c) { c->width = c->height = 0x80000000U; }, "2147483648 x 2147483648"},
           {[](Cloud* c) { c->row_step = 47; }, "row_step is 47, but a row has 48 bytes"},
           {[](Cloud* c) { c->point_step = 0x40000003U; }, "a row has 4294967308 bytes"},
           {[](Cloud* c) { c->data.pop_back(); }, "data has 47 bytes, but row_step x height is 48"},
           {[](Cloud* c) { c->data.push_back(0); }, "data has 49 bytes"},
           {[](Cloud* c) { c->point_step = 11; }, "'z' ends at byte 12, but point_step is 11"},
           {[](Cloud* c) { c->point_step = 0; }, "'x' ends at byte 4, but point_step is 0"},
           {[](Cloud* c) { c->fields[1].offset = 0xFFFFFFFFU; }, "'y' ends at byte 4294967299"},
           {[](Cloud* c) { c->fields[2].datatype = 8; }, "'z' ends at byte 16"},
           {[](Cloud* c) { c->fields[2].datatype = 6; }, "'z' has datatype 6, neither FLOAT32"},
           {[](Cloud* c) { c->fields[2].count = 3; }, "'z' has count 3"},
           {[](Cloud* c) { c->fields[2].name = "Z"; }, "no field 'z'"},
           {[](Cloud* c) { c->fields[2].name = "x"; }, "two fields 'x'"},
           {[](Cloud* c) { c->fields.clear(); }, "no field 'x'"}}) {
    Cloud cloud = asPointCloud(square());
    bad.spoil(&cloud);
    expectIn(bad.why, refusalOf(cloudAdapter(square()), cloud));
  }
}

// The data ends exactly where its vector ends, so sanitizers see every read beyond it.
TEST(PointCloudAdapter, AnyNumbersInACloudDoNoHarm) {
  std::mt19937 random(5);
  const std::uint32_t likely[] = {0, 1, 2, 4, 8, 11, 12, 13, 24, 48, 49, 0x7FFFFFFF, 0xFFFFFFFF};
  int taken = 0;
  for (int i = 0; i < 20000; ++i) {
    sensor_msgs::PointCloud2 cloud = asPointCloud(square());
    std::vector<std::uint32_t*> numbers = {&cloud.width, &cloud.height, &cloud.point_step,
                                           &cloud.row_step};
    for (sensor_msgs::PointField& field : cloud.fields) numbers.push_back(&field.offset);
    for (std::size_t left = 1 + random() % 3; left > 0; --left) {
      *numbers[random() % numbers.size()] = likely[random() % std::size(likely)];
    }
    cloud.fields[random() % 3].datatype = 7 + random() % 2;
    cloud.data.resize(random() % 4 == 0 ? random() % 100 : 48);
    cloud.data.shrink_to_fit();
    PointCloudAdapter adapter = cloudAdapter(square());
    try {
      EXPECT_EQ(adapter.adapt(cloud, kReceived).message->vertices.size(), 12U);
      ++taken;
    } catch (const std::invalid_argument&) {
    }
  }
  EXPECT_GT(taken, 100);
}

}  // namespace
}  // namespace deformable_contact_monitor
