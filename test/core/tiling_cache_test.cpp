// Tilings made beside detection: when they are begun, kept, forgotten, stopped, and what happens
// where there is no memory for them.
#include "core/tiling_cache.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "limited_memory.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kSettled = TilingCache::kSettledAfter;

Scene sceneOf(std::vector<TriangleMesh> meshes) {
  Scene scene;
  for (TriangleMesh& mesh : meshes) {
    scene.addBody("body " + std::to_string(scene.bodyCount()), std::move(mesh));
  }
  return scene;
}

TriangleMesh cloth(int n) { return clothGrid(n, 1, 0, 0.1F); }

// One cycle; how many bodies have a tiling, each of which is its own.
std::size_t askAll(TilingCache& cache, const Scene& scene) {
  std::size_t there = 0;
  for (const Body& body : scene.bodies()) {
    const std::shared_ptr<const Tiling> tiling = cache.of(body);
    if (tiling == nullptr) continue;
    ++there;
    EXPECT_EQ(body.mesh.triangleCount(), tiling->triangle.size());
  }
  return there;
}

void settle(TilingCache& cache, const Scene& scene) {
  for (std::uint32_t i = 0; i < kSettled; ++i) askAll(cache, scene);
  cache.wait();
}

TEST(TilingCaches, MakeOneOnceABodyHasSettled) {
  const Scene scene = sceneOf({cloth(300)});
  TilingCache cache;
  cache.wait();
  for (std::uint32_t i = 0; i + 1 < kSettled; ++i) {
    EXPECT_EQ(nullptr, cache.of(scene.body(0)));
    cache.wait();
  }
  EXPECT_EQ(nullptr, cache.of(scene.body(0)));
  std::this_thread::sleep_for(std::chrono::milliseconds(5));  // it is at work
  cache.wait();
  const std::shared_ptr<const Tiling> tiling = cache.of(scene.body(0));
  ASSERT_NE(nullptr, tiling);
  EXPECT_EQ(tilingBySurface(scene.body(0).mesh).triangle, tiling->triangle);
  EXPECT_EQ(tiling, cache.of(scene.body(0)));
}

TEST(TilingCaches, KeepThatOfEachBodyAsItMoves) {
  Scene scene = sceneOf({cloth(10), {}, cloth(1), cloth(30)});
  TilingCache cache;
  settle(cache, scene);
  std::vector<std::shared_ptr<const Tiling>> tilings;
  for (const Body& body : scene.bodies()) tilings.push_back(cache.of(body));
  EXPECT_EQ(4U, std::set<std::shared_ptr<const Tiling>>(tilings.begin(), tilings.end()).size());
  for (int cycle = 0; cycle < 100; ++cycle) {
    std::vector<float> vertices = scene.body(0).mesh.vertices;
    for (float& x : vertices) x += 0.1F;
    scene.setVertices(0, vertices.data(), vertices.size() / 3);
    for (BodyId i = 0; i < 4; ++i) ASSERT_EQ(tilings[i], cache.of(scene.body(i)));
  }
}

TEST(TilingCaches, BeginNothingWhileTheTopologyChanges) {
  Scene scene = sceneOf({cloth(10), cloth(20)});
  TilingCache cache;
  for (int cycle = 0; cycle < 50; ++cycle) {
    scene.setMesh(1, cloth(20));
    cache.of(scene.body(0));
    EXPECT_EQ(nullptr, cache.of(scene.body(1)));
    cache.wait();
  }
  EXPECT_NE(nullptr, cache.of(scene.body(0)));
  settle(cache, scene);
  EXPECT_EQ(2U, askAll(cache, scene));
}

TEST(TilingCaches, ForgetWhatNoBodyHas) {
  const Scene scene = sceneOf({cloth(10), cloth(20), cloth(30)});
  TilingCache cache;
  settle(cache, scene);
  const std::weak_ptr<const Tiling> of_first = cache.of(scene.body(0));
  EXPECT_FALSE(of_first.expired());
  for (int cycle = 0; cycle < 10; ++cycle) {
    for (BodyId i = 1; i < 3; ++i) EXPECT_NE(nullptr, cache.of(scene.body(i)));
  }
  EXPECT_TRUE(of_first.expired());
  EXPECT_EQ(nullptr, cache.of(scene.body(0)));
  settle(cache, scene);
  EXPECT_EQ(3U, askAll(cache, scene));
}

TEST(TilingCaches, WhatIsForgottenOutlivesThemForThoseWhoHaveIt) {
  const Scene scene = sceneOf({cloth(10)});
  std::shared_ptr<const Tiling> tiling;
  {
    TilingCache cache;
    settle(cache, scene);
    tiling = cache.of(scene.body(0));
  }
  ASSERT_NE(nullptr, tiling);
  EXPECT_EQ(200U, tiling->triangle.size());
}

// The copy is of the moment at which it was begun.
TEST(TilingCaches, AreOfAMeshThatChangesMeanwhile) {
  Scene scene = sceneOf({cloth(200)});
  const Scene before = scene;
  TilingCache cache;
  for (std::uint32_t i = 0; i < kSettled; ++i) cache.of(scene.body(0));
  const std::vector<float> zeros(scene.body(0).mesh.vertices.size());
  scene.setVertices(0, zeros.data(), zeros.size() / 3);
  cache.wait();
  const std::shared_ptr<const Tiling> tiling = cache.of(scene.body(0));
  ASSERT_NE(nullptr, tiling);
  EXPECT_EQ(tilingBySurface(before.body(0).mesh).triangle, tiling->triangle);
  for (int i = 0; i < 20; ++i) {  // and the body itself may go
    Scene other = sceneOf({cloth(150)});
    for (std::uint32_t call = 0; call < kSettled; ++call) cache.of(other.body(0));
  }
  cache.wait();
}

TEST(TilingCaches, EndInTheMidstOfTheirWork) {
  const Scene scene = sceneOf({cloth(700)});
  for (int i = 0; i < 60; ++i) {
    TilingCache cache;
    for (std::uint32_t call = 0; call < kSettled; ++call) cache.of(scene.body(0));
    if (i % 2 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(i / 2));
  }
}

// The cache does not tile meshes that no longer exist, because this would delay the others.
TEST(TilingCaches, DropWorkThatNobodyAsksFor) {
  TilingCache cache;
  const Scene small = sceneOf({cloth(2)});
  for (int i = 0; i < 60; ++i) {
    const Scene large = sceneOf({cloth(300)});
    for (std::uint32_t call = 0; call < 2 * kSettled; ++call) cache.of(large.body(0));
  }
  settle(cache, small);
  EXPECT_EQ(1U, askAll(cache, small));
}

// Too little for a copy of the mesh (12 bytes a triangle), and for the work (24).
TEST(TilingCaches, HaveNoneWhereThereIsNoMemory) {
  const Scene scene = sceneOf({cloth(100), cloth(10)});
  const std::size_t triangles = scene.body(0).mesh.triangleCount();
  for (const std::size_t most : {11 * triangles, 13 * triangles}) {
    TilingCache cache;
    const LimitedMemory limit(most);
    settle(cache, scene);
    settle(cache, scene);
    EXPECT_EQ(nullptr, cache.of(scene.body(0))) << most;
    EXPECT_NE(nullptr, cache.of(scene.body(1))) << most;
  }
}

TEST(TilingCaches, RememberNoEndOfTopologies) {
  const Scene settled = sceneOf({cloth(10)});
  TilingCache cache;
  settle(cache, settled);
  const std::weak_ptr<const Tiling> tiling = cache.of(settled.body(0));
  Body body;
  body.topology_revision = std::uint64_t{1} << 40;
  for (int i = 0; i < 400000; ++i, ++body.topology_revision) ASSERT_EQ(nullptr, cache.of(body));
  EXPECT_TRUE(tiling.expired());
}

}  // namespace
}  // namespace deformable_contact_monitor
