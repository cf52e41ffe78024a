// Clouds of any layout as meshes.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "adapter_checks.h"

namespace deformable_contact_monitor {
namespace {

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

// Coordinates anywhere within a point, in either precision, with gaps between points and rows.
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

// Beyond the data lies nothing: sanitizers watch.
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
