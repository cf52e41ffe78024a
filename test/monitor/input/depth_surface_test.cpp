// Tests of the triangles, lines and points that are made of the pixels of a depth camera.
#include "monitor/input/depth_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "adapter_checks.h"

namespace deformable_contact_monitor {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Triangles = std::vector<Triangle>;

constexpr double kJump = 0.05;

// An image of pixels that lie 1 m in front of the camera.
struct Image {
  Image(std::size_t columns, std::size_t rows) : width(columns), height(rows) {
    for (std::size_t i = 0; i < width * height; ++i) {
      const float column = static_cast<float>(i % width), row = static_cast<float>(i / width);
      points.insert(points.end(), {0.001F * column, 0.001F * row, 1});
    }
  }

  void setDepth(std::size_t column, std::size_t row, float z) {
    points[3 * (row * width + column) + 2] = z;
  }

  DepthSurface surface(double jump = kJump) const {
    return depthSurface(points, width, height, jump);
  }

  Triangles triangles(double jump = kJump) const {
    const std::vector<std::uint32_t> flat = surface(jump).triangles;
    Triangles all;
    for (std::size_t i = 0; i < flat.size(); i += 3) {
      all.push_back({flat[i], flat[i + 1], flat[i + 2]});
    }
    return all;
  }

  TriangleMesh mesh() const {
    TriangleMesh mesh;
    mesh.vertices.insert(mesh.vertices.end(), points.begin(), points.end());
    return mesh;
  }

  std::size_t width, height;
  std::vector<float> points;
};

TEST(DepthSurface, FourPixelsAreDividedFromTheUpperRightToTheLowerLeft) {
  EXPECT_EQ(Image(2, 2).triangles(), (Triangles{{0, 2, 1}, {1, 2, 3}}));
  EXPECT_EQ(Image(3, 2).triangles(), (Triangles{{0, 3, 1}, {1, 3, 4}, {1, 4, 2}, {2, 4, 5}}));
  EXPECT_EQ(Image(20, 30).triangles().size(), 2U * 19 * 29);
  EXPECT_EQ(Image(3, 1).triangles(), (Triangles{{0, 1, 1}, {1, 2, 2}}));
  EXPECT_EQ(Image(1, 3).triangles(), (Triangles{{0, 1, 1}, {1, 2, 2}}));
}

TEST(DepthSurface, TrianglesFaceTheCamera) {
  Image image(6, 5);
  image.setDepth(2, 2, kNan);  // so that both diagonals occur
  image.setDepth(3, 0, kNan);
  for (const Triangle& t : image.triangles()) {
    const float* a = &image.points[3 * t[0]];
    const float* b = &image.points[3 * t[1]];
    const float* c = &image.points[3 * t[2]];
    const double normal_z = (double{b[0]} - a[0]) * (double{c[1]} - a[1]) -
                            (double{b[1]} - a[1]) * (double{c[0]} - a[0]);
    EXPECT_LT(normal_z, 0);
  }
}

TEST(DepthSurface, APixelWithoutADepthCostsItsOwnCornerOnly) {
  for (const float z : {kNan, kInfinity, -kInfinity}) {
    for (std::size_t hidden = 0; hidden < 4; ++hidden) {
      Image image(2, 2);
      image.setDepth(hidden % 2, hidden / 2, z);
      const Triangles all = image.triangles();
      ASSERT_EQ(all.size(), 1U) << hidden;
      EXPECT_EQ(std::count(all[0].begin(), all[0].end(), hidden), 0);
      EXPECT_EQ(image.surface().pixels_with_depth, 3U);
    }
  }
  Image image(4, 4);
  image.setDepth(1, 1, kNan);
  EXPECT_EQ(image.triangles().size(), 18U - 4);
  Image without_x(2, 2);
  without_x.points[0] = kNan;
  EXPECT_EQ(without_x.triangles(), (Triangles{{1, 2, 3}}));
}

// Some drivers send zeros where there is no depth.
TEST(DepthSurface, ZerosAreNoDepth) {
  Image image(3, 3);
  std::fill(image.points.begin(), image.points.begin() + 9, 0.F);
  EXPECT_EQ(image.triangles().size(), 4U);
  EXPECT_EQ(image.surface().pixels_with_depth, 6U);
  std::fill(image.points.begin(), image.points.end(), -0.F);
  EXPECT_TRUE(image.triangles().empty());
}

TEST(DepthSurface, TheRatioOfDepthsDecidesAndItsEndIsIncluded) {
  const float far = 1.5F, beyond = std::nextafter(far, 2.F);
  for (const float sign : {1.F, -1.F}) {
    Image image(2, 2);
    for (float& coordinate : image.points) coordinate = coordinate == 1 ? sign : 0;
    image.setDepth(1, 1, sign * far);
    EXPECT_EQ(image.triangles(0.5).size(), 2U);
    image.setDepth(1, 1, sign * beyond);
    EXPECT_EQ(image.triangles(0.5), (Triangles{{0, 2, 1}, {3, 3, 3}}));
    image.setDepth(1, 1, sign);
    EXPECT_EQ(image.triangles(0).size(), 2U) << "equal depths may always be joined";
  }
}

TEST(DepthSurface, TheDistanceFromTheCameraIsTheDepthAlongNoAxis) {
  Image image(2, 2);
  image.points = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1};
  EXPECT_EQ(image.triangles(0).size(), 2U);
}

TEST(DepthSurface, AStepIsCutAndBothSidesStay) {
  Image image(8, 4);
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 4; column < 8; ++column) image.setDepth(column, row, 1.2F);
  }
  const Triangles all = image.triangles();
  EXPECT_EQ(all.size(), 2U * 3 * 6);
  for (const Triangle& t : all) {
    EXPECT_EQ(t[0] % 8 < 4, t[1] % 8 < 4);
    EXPECT_EQ(t[0] % 8 < 4, t[2] % 8 < 4);
  }
  EXPECT_EQ(image.triangles(0.21).size(), 2U * 3 * 7);
}

// If the ends of the usual diagonal differ, the other one gives two triangles.
TEST(DepthSurface, TheOtherDiagonalIsUsedWhereItGivesMore) {
  Image image(2, 2);
  image.setDepth(0, 0, 1.04F);
  image.setDepth(1, 1, 1.04F);
  image.setDepth(0, 1, 1.08F);
  EXPECT_EQ(image.triangles(), (Triangles{{0, 2, 3}, {0, 3, 1}}));
}

// A table that the camera sees at a flat angle: the rows' depths differ by more than a tenth.
TEST(DepthSurface, RowsThatLieFarApartAreLines) {
  Image image(3, 2);
  for (std::size_t column = 0; column < 3; ++column) image.setDepth(column, 1, 1.2F);
  EXPECT_EQ(image.triangles(), (Triangles{{0, 1, 1}, {1, 2, 2}, {3, 4, 4}, {4, 5, 5}}));
}

TEST(DepthSurface, ACableOfOnePixelsWidthIsALine) {
  Image straight(3, 3), slanted(3, 3);
  for (std::size_t i = 0; i < 3; ++i) {
    straight.setDepth(1, i, 0.5F);
    slanted.setDepth(i, i, 0.5F);
  }
  const Triangles lines = straight.triangles();
  for (const Triangle& line : {Triangle{1, 4, 4}, Triangle{4, 7, 7}, Triangle{0, 3, 3}}) {
    EXPECT_EQ(std::count(lines.begin(), lines.end(), line), 1) << line[0];
  }
  EXPECT_EQ(lines.size(), 6U);
  EXPECT_EQ(slanted.triangles(), (Triangles{{1, 5, 2}, {3, 6, 7}, {0, 4, 4}, {4, 8, 8}}));
}

TEST(DepthSurface, APixelThatIsLikeNoNeighbourIsAPoint) {
  Image image(3, 3);
  image.setDepth(1, 1, 0.5F);
  image.setDepth(0, 0, kNan);
  EXPECT_EQ(image.triangles(), (Triangles{{1, 5, 2}, {3, 6, 7}, {5, 7, 8}, {4, 4, 4}}));
}

// An image whose depths are 16 to 23 [m], so that no product or sum of the rule's is rounded.
Image randomImage(std::mt19937* random) {
  Image image(2 + (*random)() % 6, 2 + (*random)() % 6);
  for (std::size_t i = 0; i < image.points.size(); i += 3) {
    const bool is_hidden = (*random)() % 5 == 0;
    image.points[i] = image.points[i + 1] = 0;
    image.points[i + 2] = is_hidden ? kNan : static_cast<float>(16 + (*random)() % 8);
  }
  return image;
}

// Returns whether all have a depth, and the largest is at most an eighth above the smallest.
bool areSimilar(const Image& image, const Triangle& pixels) {
  float low = kInfinity, high = 0;
  for (const std::uint32_t pixel : pixels) {
    const float z = image.points[3 * pixel + 2];
    if (std::isnan(z)) return false;
    low = std::min(low, z);
    high = std::max(high, z);
  }
  return 8 * high <= 9 * low;
}

// What the rule says, one triangle at a time.
TEST(DepthSurface, RandomImagesFollowTheRule) {
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    const Image image = randomImage(&random);
    Triangles expected;
    const std::uint32_t w = static_cast<std::uint32_t>(image.width);
    for (std::uint32_t a = 0; a + w + 1 < image.width * image.height; ++a) {
      if (a % w == w - 1) continue;
      Triangles usual, other;
      for (const Triangle& t : {Triangle{a, a + w, a + 1}, Triangle{a + 1, a + w, a + w + 1}}) {
        if (areSimilar(image, t)) usual.push_back(t);
      }
      for (const Triangle& t : {Triangle{a, a + w, a + w + 1}, Triangle{a, a + w + 1, a + 1}}) {
        if (areSimilar(image, t)) other.push_back(t);
      }
      const Triangles& more = other.size() > usual.size() ? other : usual;
      expected.insert(expected.end(), more.begin(), more.end());
    }
    Triangles all = image.triangles(0.125);
    ASSERT_GE(all.size(), expected.size());
    all.resize(expected.size());
    EXPECT_EQ(all, expected) << "lines and points come after them";
  }
}

TEST(DepthSurface, NoPixelWithADepthIsLost) {
  std::mt19937 random(2);
  std::size_t lines = 0, points = 0;
  for (int round = 0; round < 300; ++round) {
    const Image image = randomImage(&random);
    const auto w = static_cast<int>(image.width);
    std::set<std::uint32_t> in_triangles, seen;
    std::set<std::pair<std::uint32_t, std::uint32_t>> joined;
    std::set<std::uint32_t> alone;
    for (const Triangle& t : image.triangles(0.125)) {
      seen.insert(t.begin(), t.end());
      if (t[1] != t[2]) {
        in_triangles.insert(t.begin(), t.end());
      } else if (t[0] != t[1]) {
        EXPECT_TRUE(joined.insert(std::minmax(t[0], t[1])).second) << "the same line twice";
      } else {
        alone.insert(t[0]);
      }
    }
    EXPECT_EQ(seen.size(), image.surface().pixels_with_depth);
    std::set<std::pair<std::uint32_t, std::uint32_t>> expected;
    std::set<std::uint32_t> with_line;
    for (std::uint32_t a = 0; a < image.width * image.height; ++a) {
      for (std::uint32_t b = a + 1; b < image.width * image.height; ++b) {
        const int columns = static_cast<int>(b) % w - static_cast<int>(a) % w;
        const int rows = static_cast<int>(b) / w - static_cast<int>(a) / w;
        const bool is_lone = in_triangles.count(a) == 0 || in_triangles.count(b) == 0;
        if (std::abs(columns) > 1 || rows > 1 || !is_lone || !areSimilar(image, {a, b, b}))
          continue;
        expected.insert({a, b});
        with_line.insert({a, b});
      }
    }
    EXPECT_EQ(joined, expected);
    for (const std::uint32_t pixel : alone) {
      EXPECT_EQ(with_line.count(pixel) + in_triangles.count(pixel), 0U);
    }
    lines += joined.size();
    points += alone.size();
  }
  EXPECT_GT(lines, 100U);
  EXPECT_GT(points, 50U);
}

CloudLayout layoutOf(const Image& image) {
  CloudLayout layout;
  layout.height = static_cast<std::uint32_t>(image.height);
  return layout;
}

TEST(DepthCloudAdapter, AnImageIsTheMeshOfItsPixels) {
  Image image(5, 4);
  image.setDepth(2, 1, kNan);
  DepthCloudAdapter adapter{DepthRule()};
  const sensor_msgs::PointCloud2 cloud = asPointCloud(image.mesh(), layoutOf(image));
  const IncomingMesh mesh = adapter.adapt(cloud, kReceived);
  EXPECT_EQ(bitsOf(mesh.message->vertices), bitsOf(image.points));
  EXPECT_EQ(mesh.message->triangles, image.surface().triangles);
  EXPECT_EQ(mesh.message->header, cloud.header);
  Accepting input;
  const auto first = input.accept(mesh);
  EXPECT_EQ(input.accept(adapter.adapt(cloud, kReceived)), first) << "the triangles are the same";
  image.setDepth(3, 2, kNan);
  const auto second =
      input.accept(adapter.adapt(asPointCloud(image.mesh(), layoutOf(image)), kReceived));
  EXPECT_NE(second->id, first->id);
  EXPECT_EQ(second->triangles.size(), image.surface().triangles.size());
}

TEST(DepthCloudAdapter, AnImageOfAnotherSizeWithTheSameTrianglesIsAnotherTopology) {
  DepthCloudAdapter adapter{DepthRule()};
  Accepting input;
  for (const std::size_t rows : {2U, 3U, 4U}) {
    Image image(2, rows);
    for (std::size_t row = 2; row < rows; ++row) {
      for (const std::size_t column : {0U, 1U}) image.setDepth(column, row, kNan);
    }
    const auto topology =
        input.accept(adapter.adapt(asPointCloud(image.mesh(), layoutOf(image)), kReceived));
    EXPECT_EQ(topology->vertex_count, 2 * rows);
    EXPECT_EQ(topology->triangles.size(), 6U);
  }
}

TEST(DepthCloudAdapter, WhatTheCameraDoesNotSeeIsNoFreeSpace) {
  Image image(10, 10);
  const auto refusal = [&](const DepthRule& rule) {
    return refusalOf(DepthCloudAdapter(rule), asPointCloud(image.mesh(), layoutOf(image)));
  };
  EXPECT_EQ(refusal({kJump, 1}), "");
  for (std::size_t i = 0; i < image.points.size(); ++i) {
    if (i >= 18 && (i < 30 || i >= 39)) image.points[i] = kNan;  // 9 pixels are left
  }
  EXPECT_EQ(refusal({kJump, 0.1}),
            "only 9 of 10 x 10 pixels have a depth, fewer than min_seen allows");
  EXPECT_EQ(refusal({kJump, 0.08}), "");
  std::fill(image.points.begin(), image.points.end(), kNan);
  EXPECT_EQ(refusal({kJump, 0.01}),
            "only 0 of 10 x 10 pixels have a depth, fewer than min_seen allows");
  EXPECT_EQ(refusal({kJump, 0}), "no pixel has a depth");
}

TEST(DepthCloudAdapter, WhatIsNoImageIsRefusedByName) {
  using Cloud = sensor_msgs::PointCloud2;
  const Image image(3, 3);
  const Cloud good = asPointCloud(image.mesh(), layoutOf(image));
  const auto refusal = [&](void (*spoil)(Cloud*)) {
    Cloud cloud = good;
    spoil(&cloud);
    return refusalOf(DepthCloudAdapter(DepthRule()), cloud);
  };
  EXPECT_EQ(refusal([](Cloud*) {}), "");
  expectIn("9 x 1 points, so it is not organised in rows; give its triangles by 'faces'",
           refusal([](Cloud* c) { c->width = 9, c->height = 1; }));
  expectIn("1 x 9 points", refusal([](Cloud* c) { c->width = 1, c->height = 9; }));
  expectIn("0 x 4294967295 points", refusal([](Cloud* c) { c->width = 0, c->height = ~0U; }));
  expectIn("a row has 51539607540 bytes", refusal([](Cloud* c) { c->width = ~0U; }));
  expectIn("row_step x height is 154618822620", refusal([](Cloud* c) { c->height = ~0U; }));
  expectIn("big-endian", refusal([](Cloud* c) { c->is_bigendian = 1; }));
  expectIn("no field 'z'", refusal([](Cloud* c) { c->fields.pop_back(); }));
  expectIn("point_step is 4, too few bytes for x, y and z", refusal([](Cloud* c) {
             for (auto& field : c->fields) field.offset = 0;
             c->point_step = 4;
           }));
}

}  // namespace
}  // namespace deformable_contact_monitor
