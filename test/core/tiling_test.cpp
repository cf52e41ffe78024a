// Tiles and regions of triangles: every triangle once, against naive counts, on meshes of all
// kinds.
#include "core/tiling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/limits.h"
#include "core/mesh_file.h"
#include "core/predicates/aabb.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

using TilingOf = Tiling (*)(const TriangleMesh&);
constexpr TilingOf kBySurface = [](const TriangleMesh& mesh) { return tilingBySurface(mesh); };
constexpr TilingOf kBoth[] = {tilingByPosition, kBySurface};

std::set<std::uint32_t> cornersOf(const TriangleMesh& mesh, std::uint32_t triangle) {
  const std::uint32_t* corner = &mesh.triangles[3 * std::size_t{triangle}];
  return {corner[0], corner[1], corner[2]};
}

// Begins of stretches of at least 1 and at most `most`, from 0 to `end`.
::testing::AssertionResult areBegins(const std::vector<std::uint32_t>& begin, std::size_t most,
                                     std::size_t end) {
  if (begin.empty() || begin.front() != 0 || begin.back() != end) {
    return ::testing::AssertionFailure() << "not from 0 to " << end;
  }
  for (std::size_t i = 1; i < begin.size(); ++i) {
    if (begin[i] <= begin[i - 1] || begin[i] - begin[i - 1] > most) {
      return ::testing::AssertionFailure() << begin[i - 1] << " to " << begin[i];
    }
  }
  return ::testing::AssertionSuccess();
}

void expectTileIsRight(const TriangleMesh& mesh, const Tiling& tiling, std::size_t tile) {
  const std::uint32_t begin = tiling.tile_begin[tile], end = tiling.tile_begin[tile + 1];
  const std::vector<std::uint32_t> vertices(tiling.vertex.begin() + tiling.vertex_begin[tile],
                                            tiling.vertex.begin() + tiling.vertex_begin[tile + 1]);
  std::set<std::uint32_t> expected;
  for (std::uint32_t slot = begin; slot < end; ++slot) {
    const std::set<std::uint32_t> corners = cornersOf(mesh, tiling.triangle[slot]);
    expected.insert(corners.begin(), corners.end());
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_LT(tiling.corners[slot][k], vertices.size());
      ASSERT_EQ(mesh.triangles[3 * std::size_t{tiling.triangle[slot]} + k],
                vertices[tiling.corners[slot][k]]);
    }
    std::uint32_t neighbours = 0;
    for (std::uint32_t other = begin; other < end; ++other) {
      for (const std::uint32_t v : cornersOf(mesh, tiling.triangle[other])) {
        if (corners.count(v) > 0) neighbours |= std::uint32_t{1} << (other - begin);
      }
    }
    ASSERT_EQ(neighbours, tiling.neighbours[slot]) << "slot " << slot;
  }
  ASSERT_EQ(std::vector<std::uint32_t>(expected.begin(), expected.end()), vertices);
}

void expectIsRight(const TriangleMesh& mesh, const Tiling& tiling) {
  const std::size_t count = mesh.triangleCount();
  std::vector<std::uint32_t> triangles = tiling.triangle;
  std::sort(triangles.begin(), triangles.end());
  ASSERT_EQ(count, triangles.size());
  for (std::size_t t = 0; t < count; ++t) ASSERT_EQ(t, triangles[t]);
  ASSERT_TRUE(areBegins(tiling.tile_begin, Tiling::kTileTriangles, count));
  ASSERT_TRUE(areBegins(tiling.region_begin, Tiling::kRegionTiles, tiling.tileCount()));
  ASSERT_TRUE(areBegins(tiling.vertex_begin, 3 * Tiling::kTileTriangles, tiling.vertex.size()));
  ASSERT_EQ(tiling.tileCount() + 1, tiling.vertex_begin.size());
  ASSERT_EQ(count, tiling.corners.size());
  ASSERT_EQ(count, tiling.neighbours.size());
  for (std::size_t tile = 0; tile < tiling.tileCount(); ++tile) {
    ASSERT_NO_FATAL_FAILURE(expectTileIsRight(mesh, tiling, tile)) << "tile " << tile;
  }
}

bool areSame(const Tiling& a, const Tiling& b) {
  return a.triangle == b.triangle && a.tile_begin == b.tile_begin &&
         a.region_begin == b.region_begin && a.vertex == b.vertex &&
         a.vertex_begin == b.vertex_begin && a.corners == b.corners && a.neighbours == b.neighbours;
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh = a;
  for (const std::uint32_t v : b.triangles) {
    mesh.triangles.push_back(v + static_cast<std::uint32_t>(a.vertexCount()));
  }
  mesh.vertices.insert(mesh.vertices.end(), b.vertices.begin(), b.vertices.end());
  return mesh;
}

TriangleMesh cloth(int n) { return clothGrid(n, 1, 0, 0.1F); }

// All triangles have one edge in common.
TriangleMesh bookOf(std::uint32_t pages) {
  TriangleMesh mesh = cloth(1);
  mesh.triangles.clear();
  for (std::uint32_t page = 0; page < pages; ++page) {
    const float angle = static_cast<float>(page);
    mesh.vertices.insert(mesh.vertices.end(), {std::cos(angle), std::sin(angle), 0.5F});
    mesh.triangles.insert(mesh.triangles.end(), {page % 2, 1 - page % 2, 4 + page});
  }
  return mesh;
}

TriangleMesh randomMesh(std::uint32_t triangles, std::uint32_t vertices, unsigned seed) {
  std::mt19937 random(seed);
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 3 * vertices; ++i) {
    mesh.vertices.push_back(static_cast<float>(random() % 100));
  }
  for (std::uint32_t i = 0; i < 3 * triangles; ++i) mesh.triangles.push_back(random() % vertices);
  return mesh;
}

TriangleMesh withVertices(TriangleMesh mesh, const std::function<float(std::size_t, float)>& to) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    mesh.vertices[i] = to(i, mesh.vertices[i]);
  }
  return mesh;
}

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
};

std::vector<NamedMesh> oddMeshes() {
  constexpr float kLargest = std::numeric_limits<float>::max();
  std::vector<NamedMesh> meshes = {
      {"nothing", {}},
      {"vertices alone", meshOf({})},
      {"one", soupOf(cloth(1))},
      {"cloth", cloth(40)},
      {"soup", soupOf(cloth(30))},
      {"small pieces", {}},
      {"book", bookOf(3000)},
      {"few vertices", randomMesh(2000, 7, 1)},
      {"many vertices", randomMesh(2000, 5000, 2)},
      {"a point", withVertices(cloth(40), [](std::size_t, float) { return 3; })},
      {"not numbers", withVertices(cloth(40), [](std::size_t, float) { return NAN; })},
      {"a line", withVertices(cloth(40), [](std::size_t i, float x) { return i % 3 ? 0 : x; })},
      {"some not finite", withVertices(cloth(40),
                                       [](std::size_t i, float x) {
                                         return i % 7 == 0 ? (i % 2 == 0 ? INFINITY : NAN) : x;
                                       })},
      {"the largest",
       withVertices(cloth(40),
                    [](std::size_t i, float) { return i % 5 < 2 ? kLargest : -kLargest; })},
  };
  meshes[1].mesh.vertices = {1, 2, 3};
  meshes[2].mesh.triangles.resize(3);
  for (int i = 0; i < 90; ++i) {  // of 2, 8, 18, 32 and 50 triangles
    meshes[5].mesh = joined(meshes[5].mesh, cloth(1 + i % 5));
  }
  for (const std::uint32_t triangles : {31U, 32U, 33U, 1023U, 1024U, 1025U, 2049U}) {
    meshes.push_back({std::to_string(triangles), cloth(40)});
    meshes.back().mesh.triangles.resize(3 * std::size_t{triangles});
  }
  meshes.push_back({"the same twice", joined(cloth(20), cloth(20))});
  meshes.push_back({"all one triangle", cloth(40)});
  for (std::size_t i = 3; i < meshes.back().mesh.triangles.size(); ++i) {
    meshes.back().mesh.triangles[i] = meshes.back().mesh.triangles[i % 3];
  }
  meshes.push_back({"degenerate", cloth(40)});
  for (std::size_t i = 0; i < meshes.back().mesh.triangles.size(); i += 3) {
    std::uint32_t* corner = &meshes.back().mesh.triangles[i];
    if (i % 4 == 0) corner[1] = corner[0];
    if (i % 8 == 0) corner[2] = corner[0];
  }
  return meshes;
}

TEST(Tilings, OfOddMeshesAreRight) {
  for (const NamedMesh& odd : oddMeshes()) {
    for (const TilingOf make : kBoth) {
      SCOPED_TRACE(odd.name + (make == kBySurface ? " by surface" : " by position"));
      const Tiling tiling = make(odd.mesh);
      expectIsRight(odd.mesh, tiling);
      EXPECT_TRUE(areSame(tiling, make(odd.mesh)));
    }
  }
}

TEST(Tilings, OfRandomMeshesAreRight) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const TriangleMesh mesh = randomMesh(seed * 7 % 1500, 1 + seed * 13 % 800, seed);
    for (const TilingOf make : kBoth) {
      SCOPED_TRACE(seed);
      expectIsRight(mesh, make(mesh));
    }
  }
}

TEST(Tilings, ByPositionAreFullButForTheLast) {
  for (const TriangleMesh& mesh : {cloth(40), soupOf(cloth(33)), randomMesh(1025, 40, 1)}) {
    const Tiling tiling = tilingByPosition(mesh);
    const std::size_t tiles = (mesh.triangleCount() + 31) / 32;
    EXPECT_EQ(tiles, tiling.tileCount());
    EXPECT_EQ((tiles + 31) / 32, tiling.regionCount());
  }
}

// Pairs of tiles, or of regions, whose boxes meet where the mesh is.
struct Meetings {
  std::size_t tiles = 0, regions = 0;
};

std::size_t meetingPairs(const std::vector<Aabb>& boxes) {
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size(); ++j) pairs += intersects(boxes[i], boxes[j]);
  }
  return pairs;
}

Meetings meetings(const Tiling& tiling, const TriangleMesh& mesh) {
  std::vector<Aabb> tiles(tiling.tileCount()), regions(tiling.regionCount());
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::uint32_t v = tiling.vertex_begin[i]; v < tiling.vertex_begin[i + 1]; ++v) {
      tiles[i].include(mesh.vertex(tiling.vertex[v]));
    }
  }
  for (std::size_t i = 0; i < regions.size(); ++i) {
    for (std::uint32_t t = tiling.region_begin[i]; t < tiling.region_begin[i + 1]; ++t) {
      regions[i].include(tiles[t]);
    }
  }
  return {meetingPairs(tiles), meetingPairs(regions)};
}

float middleOf(const TriangleMesh& mesh) {
  std::vector<float> x(mesh.vertexCount());
  for (std::size_t v = 0; v < x.size(); ++v) x[v] = mesh.vertex(v).x;
  std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
  return x[x.size() / 2];
}

double fill(const Tiling& tiling) {
  return static_cast<double>(tiling.triangle.size()) / static_cast<double>(tiling.tileCount());
}

// The limits are the measured numbers of pairs of tiles plus a fifth: 25 855 by position, 28 149 by
// surface.
TEST(Tilings, OfARealClothAreTight) {
  DCM_REQUIRE_TEST_DATA();
  const TriangleMesh mesh = readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply"));
  const Meetings position = meetings(tilingByPosition(mesh), mesh);
  EXPECT_LT(position.tiles, 31000U);
  EXPECT_LT(position.regions, 600U);
  const Tiling by_surface = tilingBySurface(mesh);
  const Meetings surface = meetings(by_surface, mesh);
  EXPECT_LT(surface.tiles, 34000U);
  EXPECT_LT(surface.regions, 820U);
  EXPECT_GT(fill(by_surface), 31.5);
}

// Grouped while it was folded in two, measured as it is unfolded.
TEST(Tilings, BySurfaceStayGoodAsAClothUnfolds) {
  DCM_REQUIRE_TEST_DATA();
  const TriangleMesh mesh = readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply"));
  const float middle = middleOf(mesh);
  const TriangleMesh folded = withVertices(
      mesh, [=](std::size_t i, float x) { return i % 3 == 0 ? std::abs(x - middle) : x; });
  EXPECT_LT(meetings(tilingBySurface(folded), mesh).tiles, 50000U);
  EXPECT_GT(meetings(tilingByPosition(folded), mesh).tiles, 100000U);
}

// As good as without, but for the tiles in which such vertices are.
TEST(Tilings, AreAsTightBesideVerticesThatAreNotFinite) {
  const TriangleMesh mesh = cloth(64);
  const TriangleMesh holed = withVertices(mesh, [](std::size_t i, float x) {
    return i % 300 == 0 ? (i % 600 == 0 ? NAN : INFINITY) : x;
  });
  for (const TilingOf make : kBoth) {
    EXPECT_LT(meetings(make(holed), mesh).tiles, 2 * meetings(make(mesh), mesh).tiles);
  }
}

// Two layers, one on the other: what is one piece stays apart from the other.
TEST(Tilings, BySurfaceAreOfOnePiece) {
  const TriangleMesh layer = clothGrid(64, 1, 0, 0);  // 8 regions
  const Tiling tiling = tilingBySurface(joined(layer, layer));
  for (std::size_t r = 0; r < tiling.regionCount(); ++r) {
    const std::uint32_t begin = tiling.tile_begin[tiling.region_begin[r]];
    const std::uint32_t end = tiling.tile_begin[tiling.region_begin[r + 1]];
    if (end - begin < 4 * Tiling::kTileTriangles) continue;  // gathered from small pieces
    const bool first = tiling.triangle[begin] < layer.triangleCount();
    for (std::uint32_t i = begin; i < end; ++i) {
      ASSERT_EQ(first, tiling.triangle[i] < layer.triangleCount()) << "region " << r;
    }
  }
  EXPECT_GT(fill(tiling), 31);
}

// Steps that grew with the square of what a vertex, an edge or a mesh has would take hours.
TEST(Tilings, OfAMillionTrianglesInOneEdgeAreMade) {
  for (const TriangleMesh& mesh : {bookOf(1000000), randomMesh(1000000, 3, 1)}) {
    for (const TilingOf make : kBoth) EXPECT_GT(fill(make(mesh)), 31);
  }
}

TEST(Tilings, EndBeforeTheyBegin) {
  const std::atomic<bool> stop{true};
  Limits limits;
  limits.stop = &stop;
  for (const NamedMesh& odd : oddMeshes()) {
    EXPECT_EQ(0U, tilingBySurface(odd.mesh, limits).neighbours.size()) << odd.name;
  }
}

// Ended at each of many moments it is complete or empty.
TEST(Tilings, EndAtAnyMoment) {
  const TriangleMesh mesh = joined(cloth(120), soupOf(cloth(80)));
  const Tiling whole = tilingBySurface(mesh);
  int ended = 0, made = 0;
  for (int i = 0; i < 200 || made == 0; ++i) {
    Limits limits;
    limits.deadline = std::chrono::steady_clock::now() + std::chrono::microseconds(100 * i);
    const Tiling tiling = tilingBySurface(mesh, limits);
    const bool is_ended = tiling.tileCount() == 0;
    ended += is_ended ? 1 : 0;
    made += is_ended ? 0 : 1;
    if (!is_ended) {
      ASSERT_TRUE(areSame(whole, tiling)) << i;
    }
  }
  EXPECT_GT(ended, 0);
}

}  // namespace
}  // namespace deformable_contact_monitor
