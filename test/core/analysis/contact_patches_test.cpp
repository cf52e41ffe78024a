// Patches against a graph of contacts searched by brute force.
#include "core/analysis/contact_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "core/common/posed_body.h"
#include "core/cpu_detector.h"
#include "refusal.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

using Triangles = std::vector<std::uint32_t>;
// Bodies, triangles of both, and how many contacts.
using Shape = std::tuple<BodyId, BodyId, Triangles, Triangles, std::size_t>;

Shape shapeOf(const Patch& patch) {
  return {patch.body_a, patch.body_b, patch.triangles_a, patch.triangles_b, patch.pair_count};
}

bool shareAVertex(const Body& body, std::uint32_t s, std::uint32_t t) {
  const Triangle a = PosedBody(body).received(s), b = PosedBody(body).received(t);
  for (const Vec3f& u : a.v) {
    for (const Vec3f& v : b.v) {
      if (u == v) return true;
    }
  }
  return s == t;
}

bool hangTogether(const Scene& scene, const TrianglePair& p, const TrianglePair& q) {
  if (p.body_a != q.body_a || p.body_b != q.body_b) return false;
  const Body &a = scene.body(p.body_a), &b = scene.body(p.body_b);
  if (shareAVertex(a, p.triangle_a, q.triangle_a)) return true;
  if (shareAVertex(b, p.triangle_b, q.triangle_b)) return true;
  return p.body_a == p.body_b && (shareAVertex(a, p.triangle_a, q.triangle_b) ||
                                  shareAVertex(a, p.triangle_b, q.triangle_a));
}

std::set<Shape> expectedShapes(const Scene& scene, const std::vector<TrianglePair>& contacts) {
  std::set<Shape> shapes;
  std::vector<bool> seen(contacts.size(), false);
  for (std::size_t first = 0; first < contacts.size(); ++first) {
    if (seen[first]) continue;
    seen[first] = true;
    std::vector<std::size_t> to_visit{first};
    std::set<std::uint32_t> a, b;
    std::size_t count = 0;
    while (!to_visit.empty()) {
      const std::size_t i = to_visit.back();
      to_visit.pop_back();
      ++count;
      a.insert(contacts[i].triangle_a);
      b.insert(contacts[i].triangle_b);
      for (std::size_t j = 0; j < contacts.size(); ++j) {
        if (seen[j] || !hangTogether(scene, contacts[i], contacts[j])) continue;
        seen[j] = true;
        to_visit.push_back(j);
      }
    }
    shapes.insert({contacts[first].body_a, contacts[first].body_b, Triangles(a.begin(), a.end()),
                   Triangles(b.begin(), b.end()), count});
  }
  return shapes;
}

std::set<Shape> shapesOf(const std::vector<Patch>& patches) {
  std::set<Shape> shapes;
  for (const Patch& patch : patches) shapes.insert(shapeOf(patch));
  EXPECT_EQ(shapes.size(), patches.size());
  return shapes;
}

DetectionResult withoutGeometry(const std::vector<TrianglePair>& contacts) {
  DetectionResult result;
  result.contacts = contacts;
  result.geometry.resize(contacts.size());
  return result;
}

// Pieces of cloth, crossing at random, some as soups; a body also meets itself.
Scene clothes(std::mt19937* random) {
  const auto below = [random](unsigned n) { return (*random)() % n; };
  Scene scene;
  for (int body = 0; body < 3; ++body) {
    TriangleMesh mesh = clothGrid(3 + static_cast<int>(below(3)), 1, 0, 0.3F);
    for (float& x : mesh.vertices) x += 0.05F * static_cast<float>(below(5));
    for (int k = 0; k < 4; ++k) {  // pieces go
      const std::size_t t = 3 * below(static_cast<unsigned>(mesh.triangleCount()));
      mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t),
                           mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t + 3));
    }
    if (below(3) == 0) mesh = soupOf(mesh);
    const BodyId id = scene.addBody(std::to_string(body), mesh);
    RigidTransform pose;
    for (double& x : pose.translation) x = 0.2 * below(5);
    scene.setPose(id, pose);
  }
  for (BodyId a = 0; a < 3; ++a) {
    for (BodyId b = a; b < 3; ++b) scene.setPairEnabled(a, b, below(4) > 0);
  }
  return scene;
}

TEST(ContactPatches, EqualTheGraphsComponents) {
  std::mt19937 random(1);
  const auto detector = makeCpuDetector();
  PatchFinder finder;
  std::size_t patches = 0, many = 0;
  for (int i = 0; i < 300; ++i) {
    const Scene scene = clothes(&random);
    const std::vector<TrianglePair> contacts = detector->detect(scene, Options()).contacts;
    const std::set<Shape> expected = expectedShapes(scene, contacts);
    ASSERT_EQ(shapesOf(finder.find(scene, withoutGeometry(contacts))), expected) << i;
    patches += expected.size();
    many += expected.size() > 3;
  }
  EXPECT_GT(patches, 300U);
  EXPECT_GT(many, 30U);
}

// Any pairs at all, of soups on a small grid: also such as no detector finds.
TEST(ContactPatches, EqualTheGraphsComponentsOfAnyPairs) {
  std::mt19937 random(2);
  PatchFinder finder;
  for (int i = 0; i < 200; ++i) {
    std::vector<Triangle> triangles(40);
    for (Triangle& t : triangles) {
      for (Vec3f& v : t.v) {
        const auto any = [&random] { return static_cast<float>(random() % 6) - 1; };
        v = {any(), any(), random() % 2 == 0 ? 0.0F : -0.0F};
      }
    }
    const Scene scene = pairScene(meshOf(triangles), meshOf(triangles));
    std::set<TrianglePair> pairs;
    for (int k = 0; k < 8; ++k) {
      const std::uint32_t s = random() % 40, t = random() % 40;
      pairs.insert({0, s, 1, t});
      if (s < t) pairs.insert({0, s, 0, t});
    }
    const std::vector<TrianglePair> contacts(pairs.begin(), pairs.end());
    ASSERT_EQ(shapesOf(finder.find(scene, withoutGeometry(contacts))),
              expectedShapes(scene, contacts))
        << i;
  }
}

// Two triangles far apart of each body; body b is a metre above a.
Scene fourTriangles() {
  const std::vector<Triangle> a = {{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}},
                                   {{{9, 0, 0}, {10, 0, 0}, {9, 2, 0}}}};
  return pairScene(meshOf(a), meshOf(a));
}

PairGeometry geometry(Vec3f a, Vec3f b, Vec3f normal, float separation_m, int flags = 0) {
  return {a, b, normal, separation_m, static_cast<std::uint8_t>(flags)};
}

TEST(ContactPatches, SayLengthAreasCentroidAndNormal) {
  const Scene scene = fourTriangles();
  DetectionResult result;
  result.contacts = {{0, 0, 1, 0}, {0, 0, 1, 1}, {0, 1, 1, 1}};
  result.geometry = {geometry({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, -0.5F),
                     geometry({2, 0, 0}, {2, 3, 0}, {0, 1, 0}, -0.25F),
                     geometry({7, 7, 7}, {8, 8, 8}, {0, 0, 0}, 0, kCoplanar | kNormalUndefined)};
  const std::vector<Patch> patches = PatchFinder().find(scene, result);
  ASSERT_EQ(patches.size(), 1U);
  const Patch& patch = patches[0];
  EXPECT_EQ(shapeOf(patch), Shape(0, 1, {0, 1}, {0, 1}, 3));
  EXPECT_DOUBLE_EQ(patch.curve_length_m, 4);
  EXPECT_DOUBLE_EQ(patch.area_a_m2, 1.5);
  EXPECT_DOUBLE_EQ(patch.area_b_m2, 1.5);
  EXPECT_DOUBLE_EQ(patch.min_separation_m, -0.5);
  EXPECT_DOUBLE_EQ(patch.centroid.x, (0.5 * 1 + 2 * 3) / 4);
  EXPECT_DOUBLE_EQ(patch.centroid.y, 1.5 * 3 / 4);
  EXPECT_DOUBLE_EQ(patch.normal.y, std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(patch.normal.z, std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(patch.normal_spread_rad, std::acos(-1.0) / 4);
}

TEST(ContactPatches, WhatTouchesByItsRadiusAloneHasNoCurve) {
  Scene scene = fourTriangles();
  scene.setRadius(1, 0.5F);
  DetectionResult result;
  result.contacts = {{0, 0, 1, 0}, {0, 0, 1, 1}};
  result.geometry = {geometry({0, 0, 0}, {0, 0, 1}, {0, 0, 1}, -0.25F),
                     geometry({2, 0, 0}, {2, 0, 3}, {0, 0, 1}, -0.75F)};
  const Patch patch = PatchFinder().find(scene, result).at(0);
  EXPECT_EQ(patch.curve_length_m, 3) << "of the second pair, whose triangles cross";
  EXPECT_EQ(patch.min_separation_m, -0.75);
}

TEST(ContactPatches, WhatIsOnlyNearHasNoCurve) {
  const Scene scene = fourTriangles();
  DetectionResult result;
  result.contacts = {{0, 0, 1, 0}, {0, 0, 1, 1}};
  result.separations_m = {0.5F, 0.25F};
  result.geometry = {geometry({0, 0, 0}, {0, 0, 1}, {0, 0, 1}, 0.5F),
                     geometry({2, 0, 0}, {2, 0, 1}, {0, 0, 1}, 0.25F)};
  const Patch patch = PatchFinder().find(scene, result).at(0);
  EXPECT_EQ(patch.curve_length_m, 0);
  EXPECT_EQ(patch.min_separation_m, 0.25);
  EXPECT_DOUBLE_EQ(patch.centroid.x, 1);
  EXPECT_DOUBLE_EQ(patch.centroid.z, 0.5);
  EXPECT_EQ(patch.normal_spread_rad, 0);
}

TEST(ContactPatches, WhatIsUndefinedIsSaid) {
  const Scene scene = fourTriangles();
  DetectionResult result;
  result.contacts = {{0, 0, 1, 0}, {0, 1, 1, 1}};
  result.geometry = {geometry({}, {}, {}, 0, kNormalUndefined | kSeparationUndefined),
                     geometry({}, {}, {}, 0, kNormalUndefined)};
  const std::vector<Patch> patches = PatchFinder().find(scene, result);
  ASSERT_EQ(patches.size(), 2U);
  EXPECT_TRUE(std::isnan(patches[0].min_separation_m));
  EXPECT_TRUE(std::isnan(patches[0].normal_spread_rad));
  EXPECT_EQ(patches[0].normal.x, 0);
  EXPECT_EQ(patches[1].min_separation_m, 0);
}

TEST(ContactPatches, NormalsOfEitherSignDoNotCancelOut) {
  const Scene scene = fourTriangles();
  DetectionResult result;
  result.contacts = {{0, 0, 1, 0}, {0, 0, 1, 1}, {0, 1, 1, 1}};
  result.geometry = {geometry({}, {}, {0, 0, -1}, 0, kCoplanar), geometry({}, {}, {0, 0, 1}, -1),
                     geometry({}, {}, {0, 0, -1}, 0, kCoplanar)};
  Patch patch = PatchFinder().find(scene, result).at(0);
  EXPECT_EQ(patch.normal.z, 1);
  EXPECT_EQ(patch.normal_spread_rad, 0);
  result.geometry[1] = geometry({}, {}, {0, 0, 1}, -1);  // and of opposite normals nothing is made
  result.geometry[0] = result.geometry[2] = geometry({}, {}, {0, 0, -1}, -1);
  result.contacts.pop_back();
  result.geometry.pop_back();
  patch = PatchFinder().find(scene, result).at(0);
  EXPECT_EQ(patch.normal.z, 0);
  EXPECT_TRUE(std::isnan(patch.normal_spread_rad));
}

TEST(ContactPatches, NeedGeometry) {
  DetectionResult result = withoutGeometry({{0, 0, 1, 0}});
  result.geometry.clear();
  EXPECT_EQ(refusal([&] { PatchFinder().find(fourTriangles(), result); }),
            "patches need the geometry of 1 contacts, not of 0");
}

// As many contacts as can be in one patch and in as many patches, with a bound that quadratic work
// would pass.
TEST(ContactPatches, OneGiantPatchAndManySmallOnesTakeLittleTime) {
  constexpr std::uint32_t kCount = 200000;
  std::vector<Triangle> apart, joined;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const auto x = static_cast<float>(i);
    apart.push_back({{{x, 0, 0}, {x + 0.5F, 0, 0}, {x, 1, 0}}});
    joined.push_back({{{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}}});
  }
  std::vector<TrianglePair> pairs, fan;
  for (std::uint32_t i = 0; i < kCount; ++i) pairs.emplace_back(0, i, 1, i);
  for (std::uint32_t i = 0; i < kCount; ++i) fan.emplace_back(0, 0, 1, i);
  const auto start = std::chrono::steady_clock::now();
  PatchFinder finder;
  const Scene soup = pairScene(meshOf(apart), meshOf(apart));
  const Scene strip = pairScene(meshOf(joined), meshOf(joined));
  EXPECT_EQ(finder.find(soup, withoutGeometry(pairs)).size(), kCount);
  EXPECT_EQ(finder.find(soup, withoutGeometry(fan)).size(), 1U);
  EXPECT_EQ(finder.find(strip, withoutGeometry(pairs)).size(), 1U);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

}  // namespace
}  // namespace deformable_contact_monitor
