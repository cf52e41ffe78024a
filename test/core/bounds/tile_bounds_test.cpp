// Bounds of tiles, regions and triangles against distances of all pairs, on thousands of states.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "bounds_truth.h"
#include "core/bounds/body_tiles.h"
#include "core/bounds/near_parts.h"
#include "exact_distance.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kTruth = 1 + 0x1p-26;  // trueDistance() is right to a part in 2^28

class Random {
 public:
  explicit Random(std::uint32_t seed) : random_(seed) {}
  std::size_t below(std::size_t n) { return random_() % n; }
  bool isOneOf(std::size_t n) { return below(n) == 0; }
  float unit() { return static_cast<float>(random_()) * 0x1p-32F; }
  float either() { return 2 * unit() - 1; }
  Vec3f point() { return {either(), either(), either()}; }

 private:
  std::mt19937 random_;
};

// Tiles and regions of any triangles, in any order and of any sizes.
Tiling randomTiling(const TriangleMesh& mesh, Random& random) {
  Tiling tiling;
  tiling.triangle.resize(mesh.triangleCount());
  std::iota(tiling.triangle.begin(), tiling.triangle.end(), 0U);
  if (random.isOneOf(2)) {
    for (std::size_t i = tiling.triangle.size(); i > 1; --i) {
      std::swap(tiling.triangle[i - 1], tiling.triangle[random.below(i)]);
    }
  }
  std::uint32_t slot = 0;
  const auto end = static_cast<std::uint32_t>(tiling.triangle.size());
  tiling.region_begin.push_back(0);
  while (slot < end) {
    tiling.tile_begin.push_back(slot);
    tiling.vertex_begin.push_back(static_cast<std::uint32_t>(tiling.vertex.size()));
    const std::uint32_t stop =
        std::min(end, slot + 1 + static_cast<std::uint32_t>(random.below(32)));
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t s = slot; s < stop; ++s) {
      for (int k = 0; k < 3; ++k) vertices.push_back(mesh.triangles[3 * tiling.triangle[s] + k]);
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (std::uint32_t s = slot; s < stop; ++s) {
      std::array<std::uint8_t, 3> corners;
      for (int k = 0; k < 3; ++k) {
        const auto place = std::lower_bound(vertices.begin(), vertices.end(),
                                            mesh.triangles[3 * tiling.triangle[s] + k]);
        corners[k] = static_cast<std::uint8_t>(place - vertices.begin());
      }
      tiling.corners.push_back(corners);
    }
    tiling.vertex.insert(tiling.vertex.end(), vertices.begin(), vertices.end());
    slot = stop;
    if (random.isOneOf(3) ||
        tiling.tile_begin.size() - tiling.region_begin.back() == Tiling::kRegionTiles) {
      tiling.region_begin.push_back(static_cast<std::uint32_t>(tiling.tile_begin.size()));
    }
  }
  if (tiling.region_begin.back() != tiling.tile_begin.size()) {
    tiling.region_begin.push_back(static_cast<std::uint32_t>(tiling.tile_begin.size()));
  }
  tiling.tile_begin.push_back(slot);
  tiling.vertex_begin.push_back(static_cast<std::uint32_t>(tiling.vertex.size()));
  return tiling;
}

// A wavy, a flat, or a crumpled cloth, or triangles anywhere.
TriangleMesh randomMesh(Random& random) {
  switch (random.below(4)) {
    case 0:
      return clothGrid(1 + static_cast<int>(random.below(6)), 1, 0, 0.1F * random.unit());
    case 1:
      return clothGrid(1 + static_cast<int>(random.below(6)), 1, 0, 0);
    case 2: {
      TriangleMesh mesh = clothGrid(1 + static_cast<int>(random.below(6)), 1, 0, 0.2F);
      for (float& x : mesh.vertices) x += 0.1F * random.either();
      return mesh;
    }
    default: {
      std::vector<Triangle> triangles(1 + random.below(60));
      for (Triangle& t : triangles) {
        const Vec3f at = random.point();
        for (Vec3f& v : t.v) v = at + random.point() * 0.3F;
      }
      return meshOf(triangles);
    }
  }
}

void makeStrange(Random& random, TriangleMesh& mesh) {
  constexpr float kStrange[] = {1e30F,  -1e30F, 3e38F, 1e-42F,   0,
                                -3e38F, 1e10F,  NAN,   INFINITY, -INFINITY};
  for (std::size_t i = random.below(4); i > 0; --i) {
    mesh.vertices[random.below(mesh.vertices.size())] = kStrange[random.below(10)];
  }
}

// Any rotation, sometimes about nothing, sometimes with another scale.
RigidTransform randomPose(Random& random) {
  RigidTransform pose;
  if (random.isOneOf(4)) return pose;
  const double a = 3 * random.either(), b = 3 * random.either();
  const double turn[9] = {std::cos(a),
                          -std::sin(a) * std::cos(b),
                          std::sin(a) * std::sin(b),
                          std::sin(a),
                          std::cos(a) * std::cos(b),
                          -std::cos(a) * std::sin(b),
                          0,
                          std::sin(b),
                          std::cos(b)};
  const double scale = random.isOneOf(8) ? std::pow(10.0, 40 * random.either()) : 1;
  for (int i = 0; i < 9; ++i) pose.rotation[i] = scale * turn[i];
  for (double& t : pose.translation) t = 2 * random.either();
  return pose;
}

struct TiledBody {
  Scene scene;
  BodyTiles tiles;
  std::shared_ptr<const Tiling> tiling;

  explicit TiledBody(Random& random) {
    TriangleMesh mesh = randomMesh(random);
    if (random.isOneOf(8)) {
      const float scale = std::pow(10.0F, 30 * random.either());
      for (float& x : mesh.vertices) x *= scale;
    }
    if (random.isOneOf(4)) makeStrange(random, mesh);
    tiling = std::make_shared<const Tiling>(randomTiling(mesh, random));
    scene.addBody("body", mesh);
    scene.setPose(0, randomPose(random));
    EXPECT_TRUE(tiles.update(scene.body(0), tiling, noLimit()));
  }

  // Another state.
  void deform(Random& random) {
    std::vector<float> vertices = scene.body(0).mesh.vertices;
    for (float& x : vertices) x += 0.02F * random.either() * (1 + std::abs(x));
    scene.setVertices(0, vertices.data(), vertices.size() / 3);
    scene.setPose(0, randomPose(random));
    EXPECT_TRUE(tiles.update(scene.body(0), tiling, noLimit()));
  }

  std::vector<Triangle> trianglesOf(std::size_t tile) const {
    std::vector<Triangle> triangles;
    const PosedBody posed(scene.body(0));
    for (std::uint32_t s = tiling->tile_begin[tile]; s < tiling->tile_begin[tile + 1]; ++s) {
      const Triangle t = posed.triangle(tiling->triangle[s]);
      if (isFinite(t)) triangles.push_back(t);
    }
    return triangles;
  }
};

struct Seen {
  std::size_t pairs = 0, apart = 0, tight = 0;  // tight: within 0.1 % of the distance
  std::size_t along = 0;                        // apart along a direction
};

// What is said of the pairs of two tiles' triangles: `left_out` of those that are not in `near`.
void checkTriangles(const PosedTile& a, const PosedTile& b, double needed, double left_out,
                    const std::vector<NearTriangles>& near) {
  ASSERT_GE(left_out, needed);
  std::vector<bool> is_near(a.count * b.count, false);
  for (const NearTriangles& pair : near) {
    const double own = trueDistance(a.posed(pair.a), b.posed(pair.b));
    ASSERT_LE(pair.low_m, own * kTruth);
    ASSERT_TRUE(own > 0 || pair.boxes_meet);
    ASSERT_FALSE(is_near[pair.a * b.count + pair.b]);
    is_near[pair.a * b.count + pair.b] = true;
  }
  for (std::size_t i = 0; i < is_near.size(); ++i) {
    if (is_near[i]) continue;
    const double own = trueDistance(a.posed(i / b.count), b.posed(i % b.count));
    ASSERT_GE(own * kTruth, left_out);
  }
}

// Both of the pair's own, and what is said of its triangles.
void checkTiles(const TiledBody& a, std::size_t s, const TiledBody& b, std::size_t t,
                Random& random, Seen& seen) {
  const std::vector<Triangle> of_a = a.trianglesOf(s), of_b = b.trianglesOf(t);
  const double distance = trueDistance(of_a, of_b);
  const PosedTile &tile_a = a.tiles.tile(s), &tile_b = b.tiles.tile(t);
  ASSERT_EQ(of_a.size(), tile_a.count);
  const double low = lowerGap(tile_a, tile_b);
  ASSERT_LE(low, distance * kTruth);
  ++seen.pairs;
  seen.apart += distance > 0 && distance < INFINITY;
  seen.tight += distance > 0 && distance < INFINITY && low > 0.999 * distance;
  if (of_a.empty() || of_b.empty()) return;

  // Any direction, or that from some vertex to another, which may be near that of the distance.
  Vec3d direction = toDouble(random.point());
  if (random.isOneOf(2)) direction = toDouble(tile_b.vertex(0)) - toDouble(tile_a.vertex(0));
  if (direction == Vec3d()) direction = {1, 0, 0};
  const double along = lowerGapAlong(direction, tile_a, tile_b);
  ASSERT_LE(along, distance * kTruth);
  seen.along += along > 0;

  const double needed = std::max(1.5e-45, distance * 2 * random.unit());
  std::vector<NearTriangles> near;
  double left_out = nearTriangles(tile_a, tile_b, needed, near);
  checkTriangles(tile_a, tile_b, needed, left_out, near);
  left_out = nearTrianglesAlong(direction, tile_a, tile_b, needed, near);
  checkTriangles(tile_a, tile_b, needed, left_out, near);
}

void checkRegions(const TiledBody& a, const TiledBody& b, Random& random) {
  for (std::size_t r = 0; r < a.tiles.regions().size(); ++r) {
    for (std::size_t q = 0; q < b.tiles.regions().size(); ++q) {
      std::vector<Triangle> of_a, of_b;
      for (std::size_t t = a.tiles.tileBegin(r); t < a.tiles.tileEnd(r); ++t) {
        for (const Triangle& one : a.trianglesOf(t)) of_a.push_back(one);
      }
      for (std::size_t t = b.tiles.tileBegin(q); t < b.tiles.tileEnd(q); ++t) {
        for (const Triangle& one : b.trianglesOf(t)) of_b.push_back(one);
      }
      const double distance = trueDistance(of_a, of_b);
      const double needed = std::max(1.5e-45, std::min(distance, 1e30) * 2 * random.unit());
      std::vector<NearParts> regions, tiles;
      const double other_regions = nearRegions(a.tiles, r, b.tiles, needed, regions);
      const bool is_near = std::any_of(regions.begin(), regions.end(),
                                       [q](const NearParts& near) { return near.b == q; });
      if (!is_near) {
        ASSERT_LE(other_regions, distance * kTruth);
      }
      const double other_tiles = nearTiles(a.tiles, r, b.tiles, q, needed, tiles);
      ASSERT_GE(other_tiles, needed);
      double low = other_tiles;
      for (const NearParts& near : tiles) low = std::min(low, near.low_m);
      ASSERT_LE(low, distance * kTruth);
    }
  }
}

TEST(TileBounds, AreNeverMoreThanTheDistanceOnAnyState) {
  Seen seen;
  const char* const given = std::getenv("DCM_BOUND_SEEDS");
  const std::uint32_t seeds = given == nullptr ? 1500 : std::strtoul(given, nullptr, 10);
  for (std::uint32_t seed = 0; seed < seeds && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    TiledBody a(random), b(random);
    for (int state = 0; state < 2 && !HasFatalFailure(); ++state) {
      for (int i = 0; i < 4 && !HasFatalFailure(); ++i) {
        checkTiles(a, random.below(a.tiling->tileCount()), b, random.below(b.tiling->tileCount()),
                   random, seen);
      }
      if (!HasFatalFailure()) checkRegions(a, b, random);
      a.deform(random);
    }
  }
  EXPECT_GT(seen.apart, seen.pairs / 4);
  EXPECT_GT(seen.along, seen.pairs / 20);
  std::printf("%zu pairs of tiles, %zu apart, %zu bounds within 0.1 %%\n", seen.pairs, seen.apart,
              seen.tight);
}

// Patches that face each other, turned in any way: their distance is the gap itself, so that a
// bound which takes anything off a box is too large.
TEST(TileBounds, AreAttainedByPatchesThatFaceEachOther) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const int squares = 1 + static_cast<int>(random.below(3));
    TriangleMesh low = clothGrid(squares, 0.05F, 0, 0);
    TriangleMesh high = clothGrid(squares, 0.05F, 0.001F + 0.05F * random.unit(), 0);
    const RigidTransform pose = randomPose(random);
    const double scale = std::abs(
        std::sqrt(pose.rotation[0] * pose.rotation[0] + pose.rotation[3] * pose.rotation[3]));
    if (scale > 2 || scale < 0.5) continue;
    Scene scene = pairScene(low, high);
    scene.setPose(0, pose);
    scene.setPose(1, pose);
    BodyTiles tiles[2];
    for (BodyId id = 0; id < 2; ++id) {
      tiles[id].update(scene.body(id),
                       std::make_shared<const Tiling>(tilingByPosition(scene.body(id).mesh)),
                       noLimit());
    }
    const double distance =
        trueDistance(finiteTriangles(scene.body(0)), finiteTriangles(scene.body(1)));
    const double gap = lowerGap(tiles[0].tile(0), tiles[1].tile(0));
    ASSERT_LE(gap, distance * kTruth);
    ASSERT_GE(gap, distance * 0.999);
  }
}

TEST(TileBounds, TruthIsThatOfRationals) {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    Triangle a, b;
    for (int k = 0; k < 3; ++k) {
      a.v[k] = random.point();
      b.v[k] = random.point() + Vec3f{1.2F, 0, 0};
    }
    const double distance = trueDistance(a, b);
    if (distance > 0) {
      ASSERT_NEAR(exactDistance(a, b), distance, distance * 1e-8);
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
