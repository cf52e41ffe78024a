// Triangles of one body that share vertices, by index and by coordinates.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "cgal_oracle.h"
#include "detector_suite.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

constexpr float kTiny = 1e-20F;

struct Case {
  const char* name;
  Triangle a, b;
  bool beyond;  // they meet beyond the hull of the shared points
};

// Built in a function: most share the same few points.
std::vector<Case> cases() {
  const Vec3f o{0, 0, 0}, x{4, 0, 0}, y{0, 4, 0}, z{0, 0, 4}, minus_x{-4, 0, 0}, minus_y{0, -4, 0};
  const Vec3f minus_o{-0.0F, 0, -0.0F};
  const Triangle face{{o, x, y}};
  return {
      // Over the shared edge (o, x).
      {"edge: flat", face, {{o, x, minus_y}}, false},
      {"edge: right angle", face, {{o, x, z}}, false},
      {"edge: almost folded", face, {{o, x, {1, 3, kTiny}}}, false},
      {"edge: folded", face, {{o, x, {1, 3, 0}}}, true},
      {"edge: folded, reaching out", face, {{o, x, {9, 9, 0}}}, true},
      {"edge: folded, one a part of the other", face, {{o, x, {1, 1, 0}}}, true},
      {"edge: folded, equal by -0", face, {{minus_o, x, {1, 3, 0}}}, true},
      // Over the shared vertex o.
      {"vertex: apart", face, {{o, minus_x, z}}, false},
      {"vertex: coplanar, apart", face, {{o, minus_x, minus_y}}, false},
      {"vertex: coplanar, along an edge", face, {{o, {2, 0, 0}, {0, -2, 0}}}, true},
      {"vertex: coplanar overlap", face, {{o, {2, 1, 0}, {1, 2, 0}}}, true},
      {"vertex: through the face", face, {{o, {2, 2, 1}, {2, 2, -1}}}, true},
      {"vertex: through the face far out", face, {{o, {9, 9, 1}, {9, 9, -1}}}, true},
      {"vertex: just above", face, {{o, {2, 2, 1}, {2, 2, kTiny}}}, false},
      {"vertex: touching with an edge", face, {{o, {2, 2, 1}, {2, 2, 0}}}, true},
      {"vertex: an edge lies in the face", face, {{o, {1, 1, 0}, {1, 1, 9}}}, true},
      {"vertex: touches the opposite edge", face, {{o, {2, 2, 0}, {9, 9, 9}}}, true},
      // Degenerate ones: segments and points.
      {"segment on the shared edge", face, {{o, x, x}}, false},
      {"segment along an edge from its end", face, {{o, {2, 0, 0}, {2, 0, 0}}}, true},
      {"segment beyond an edge", face, {{o, x, {9, 0, 0}}}, false},
      {"segment into the face", face, {{o, {1, 1, 0}, {1, 1, 0}}}, true},
      {"segment away from the face", face, {{o, z, z}}, false},
      {"segment through the shared vertex into the face",
       face,
       {{o, {-1, -1, 0}, {1, 1, 0}}},
       true},
      {"segment ending at the shared vertex", face, {{o, {-1, -1, 0}, {-2, -2, 0}}}, false},
      {"point at the shared vertex", face, {{o, o, o}}, false},
      {"two segments, one line, overlapping", {{o, x, x}}, {{o, {2, 0, 0}, {2, 0, 0}}}, true},
      {"two segments, one line, apart", {{o, x, x}}, {{o, minus_x, minus_x}}, false},
      {"two segments crossing only there", {{o, x, x}}, {{o, y, y}}, false},
      {"two segments on the same points", {{o, x, x}}, {{x, o, o}}, false},
      {"collinear, out of the same end", {{o, x, {6, 0, 0}}}, {{o, x, {5, 0, 0}}}, true},
      {"collinear, out of different ends", {{o, x, {6, 0, 0}}}, {{o, x, {-5, 0, 0}}}, false},
      {"two points at one place", {{o, o, o}}, {{o, o, o}}, false},
      // Duplicates.
      {"the same triangle", face, face, false},
      {"the same triangle turned over", face, {{o, y, x}}, false},
  };
}

// Vertices of equal coordinates become one.
TriangleMesh welded(const std::vector<Triangle>& triangles) {
  TriangleMesh mesh = meshOf(triangles);
  for (std::uint32_t& index : mesh.triangles) {
    const auto equal = [&mesh](std::uint32_t i, std::uint32_t j) {
      return std::equal(&mesh.vertices[3 * i], &mesh.vertices[3 * i] + 3, &mesh.vertices[3 * j]);
    };
    for (std::uint32_t other = 0; other < index; ++other) {
      if (equal(other, index)) index = other;
    }
  }
  return mesh;
}

class Adjacency : public DetectorSuite {};

TEST_P(Adjacency, CasesInEveryOrderWeldedAndAsSoup) {
  for (const Case& c : cases()) {
    const std::size_t expected = c.beyond ? 1 : 0;
    std::array<int, 3> order = {0, 1, 2};
    do {
      const Triangle turned{{c.b.v[order[0]], c.b.v[order[1]], c.b.v[order[2]]}};
      for (const auto& triangles :
           {std::vector<Triangle>{c.a, turned}, std::vector<Triangle>{turned, c.a}}) {
        EXPECT_EQ(expected, contacts(selfScene(welded(triangles))).size()) << c.name;
        const Scene soup = selfScene(meshOf(triangles));
        EXPECT_EQ(expected, contacts(soup).size()) << c.name << ", soup";
        EXPECT_EQ(expected, oracleContacts(soup, AdjacentPairs::kBeyondShared).size())
            << c.name << ", oracle";
        EXPECT_TRUE(contacts(soup, withAdjacent(AdjacentPairs::kSkip)).empty()) << c.name;
      }
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

TEST_P(Adjacency, DifferentBodiesShareNothing) {
  for (const Case& c : cases()) {
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      EXPECT_EQ(1U,
                contacts(pairScene(meshOf({c.a}), meshOf({c.b})), withAdjacent(adjacent)).size())
          << c.name;
    }
  }
}

TEST_P(Adjacency, IsDecidedAsReceivedNotAsPosed) {
  // Far away float32 rounds the two neighbouring points together: they touch, and share nothing.
  const Triangle a{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  const Triangle b{{{-0.001F, 0, 0}, {-4, 0, 0}, {0, -4, 0}}};
  Scene scene = selfScene(meshOf({a, b}));
  EXPECT_TRUE(contacts(scene).empty());
  RigidTransform far;
  far.translation[0] = 1e6;
  scene.setPose(0, far);
  EXPECT_EQ(1U, oracleContacts(scene, AdjacentPairs::kSkip).size());
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    EXPECT_EQ(1U, contacts(scene, withAdjacent(adjacent)).size());
  }
}

// Triangles of some 0.2 m in a cube of 1 m. Each tenth has a vertex of an earlier one, with the
// other zero where a coordinate is zero.
TriangleMesh soupOfFewEqualVertices(int triangles) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> within(0, 1), near(-0.1F, 0.1F);
  std::vector<Triangle> soup;
  for (int t = 0; t < triangles; ++t) {
    const Vec3f at{within(random), within(random), within(random)};
    Triangle triangle;
    for (Vec3f& v : triangle.v) v = at + Vec3f{near(random), near(random), near(random)};
    triangle.v[0].z = 0;
    if (t % 10 == 9) triangle.v[1] = soup[random() % soup.size()].v[0];
    if (t % 10 == 9) triangle.v[1].z = -triangle.v[1].z;
    soup.push_back(triangle);
  }
  return meshOf(soup);
}

// A backend may search for equal vertices in another way once it knows that there are few.
TEST_P(Adjacency, OfFewEqualVerticesIsDecidedAlikeInEveryCycle) {
  TriangleMesh mesh = soupOfFewEqualVertices(600);
  Scene scene = selfScene(mesh);
  for (int cycle = 0; cycle < 7; ++cycle) {
    for (float& x : mesh.vertices) x += 0.05F * std::sin(5 * x);
    scene.setVertices(0, mesh.vertices.data(), mesh.vertexCount());
    const AdjacentPairs adjacent = kBothAdjacent[cycle / 2 % 2];
    const std::vector<TrianglePair> expected = oracleContacts(scene, adjacent);
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(samePairs(expected, contacts(scene, withAdjacent(adjacent)))) << "cycle " << cycle;
  }
}

// The same with margins, and with triangles so large that they are tested apart from the others.
TEST_P(Adjacency, OfFewEqualVerticesIsDecidedByMarginsToo) {
  TriangleMesh mesh = soupOfFewEqualVertices(500);
  const auto addLarge = [&mesh](const Triangle& triangle) {
    for (const Vec3f& v : triangle.v) {
      mesh.triangles.push_back(static_cast<std::uint32_t>(mesh.vertexCount()));
      mesh.vertices.insert(mesh.vertices.end(), {v.x, v.y, v.z});
    }
  };
  const Vec3f first{mesh.vertices[0], mesh.vertices[1], mesh.vertices[2]};
  addLarge({{first, {-900, 700, 0.4F}, {800, 600, 0.5F}}});
  addLarge({{first, {700, -900, 0.3F}, {800, 800, 0.6F}}});
  Scene scene = selfScene(mesh);
  const auto reference = makeBruteForceDetector();
  for (int cycle = 0; cycle < 8; ++cycle) {
    for (float& x : mesh.vertices) x += 0.02F * std::sin(5 * x);
    scene.setVertices(0, mesh.vertices.data(), mesh.vertexCount());
    scene.setMargin(0, cycle % 3 == 1 ? 0 : 0.02F);
    const Options options = withAdjacent(kBothAdjacent[cycle / 2 % 2]);
    const std::vector<TrianglePair> expected = reference->detect(scene, options).contacts;
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(samePairs(expected, contacts(scene, options))) << "cycle " << cycle;
  }
}

// Vertices that are not finite at first do not hide that most are equal.
TEST_P(Adjacency, OfASoupThatIsSeenLateIsDecidedAlikeInEveryCycle) {
  TriangleMesh mesh = soupOf(clothGrid(12, 1, 0, 0));
  const std::vector<float> vertices = mesh.vertices;
  std::fill(mesh.vertices.begin(), mesh.vertices.end(), std::numeric_limits<float>::quiet_NaN());
  Scene scene = selfScene(mesh);
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    EXPECT_TRUE(contacts(scene, withAdjacent(adjacent)).empty());
  }
  for (int cycle = 0; cycle < 6; ++cycle) {
    const auto phase = static_cast<float>(cycle);
    for (std::size_t i = 0; i < vertices.size(); i += 3) {
      const float x = vertices[i];
      mesh.vertices[i] = x > 0.5F ? 1 - x : x;
      mesh.vertices[i + 1] = vertices[i + 1];
      mesh.vertices[i + 2] = 0.05F * std::sin(9 * vertices[i + 1] + phase) * std::sin(20 * x);
    }
    scene.setVertices(0, mesh.vertices.data(), mesh.vertexCount());
    const AdjacentPairs adjacent = kBothAdjacent[cycle == 3 ? 0 : 1];
    const std::vector<TrianglePair> expected = oracleContacts(scene, adjacent);
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(samePairs(expected, contacts(scene, withAdjacent(adjacent)))) << "cycle " << cycle;
  }
}

// A cloth of two halves that lie on each other and meet in a seam, where each half has vertices of
// its own. `open_m`: how far the second half's vertices on the seam are from those of the first.
TriangleMesh clothWithASeam(float phase, float open_m) {
  constexpr int kSquares = 16;
  TriangleMesh mesh = clothGrid(kSquares, 1, 0, 0);
  std::vector<std::uint32_t> twin(mesh.vertexCount());
  for (std::uint32_t v = 0; v < twin.size(); ++v) {
    twin[v] = v;
    float* const p = &mesh.vertices[3 * std::size_t{v}];
    const bool second = p[0] > 0.5F, on_seam = p[0] == 0.5F;
    if (second) p[0] = 1 - p[0];
    p[2] = 0.05F * std::sin(9 * p[1] + phase) * std::sin((second ? 7 : 6) * p[0]);
    if (!on_seam) continue;
    twin[v] = static_cast<std::uint32_t>(mesh.vertexCount());
    const float of_second[3] = {p[0] - open_m, p[1], p[2] + open_m};
    mesh.vertices.insert(mesh.vertices.end(), of_second, of_second + 3);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    if (t / 6 / kSquares < kSquares / 2) continue;  // of the first half
    for (std::size_t k = t; k < t + 3; ++k) mesh.triangles[k] = twin[mesh.triangles[k]];
  }
  return mesh;
}

// The same for a mesh whose triangles share vertices by their numbers. The seam is open at times.
TEST_P(Adjacency, OfASeamIsDecidedAlikeInEveryCycle) {
  Scene scene = selfScene(clothWithASeam(0, 0));
  for (int cycle = 0; cycle < 9; ++cycle) {
    const float open_m = cycle % 4 == 2 ? 0.02F : 0;
    const TriangleMesh mesh = clothWithASeam(0.1F * static_cast<float>(cycle), open_m);
    scene.setVertices(0, mesh.vertices.data(), mesh.vertexCount());
    const AdjacentPairs adjacent = kBothAdjacent[cycle / 3 % 2];
    const std::vector<TrianglePair> expected = oracleContacts(scene, adjacent);
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(samePairs(expected, contacts(scene, withAdjacent(adjacent)))) << "cycle " << cycle;
  }
}

// A folded cloth, each twelfth vertex of which lies on another one that is up to two squares away
// in the mesh: there, triangles share vertices by their numbers and others by their places.
TriangleMesh clothWithJoinedVertices(std::mt19937& random) {
  constexpr std::uint32_t kSquares = 14, kRow = kSquares + 1;
  TriangleMesh mesh = clothGrid(kSquares, 1, 0, 0);
  const float phase = std::uniform_real_distribution<float>(0, 6)(random);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    float* const p = &mesh.vertices[i];
    const float x = p[0];
    if (x > 0.5F) p[0] = 1 - x;
    p[2] = 0.05F * std::sin(9 * p[1] + phase) * std::sin(20 * x);
  }
  const std::uint32_t count = kRow * kRow;
  for (std::uint32_t v = random() % 12; v < count; v += 12) {
    constexpr std::array<std::uint32_t, 6> kStepsAway = {1, 2, kRow, kRow + 1, kRow + 2, 2 * kRow};
    const std::size_t other = (v + kStepsAway[random() % kStepsAway.size()]) % count;
    std::copy_n(&mesh.vertices[3 * other], 3, &mesh.vertices[3 * std::size_t{v}]);
  }
  return mesh;
}

std::size_t repeatedVertices(const TriangleMesh& mesh) {
  std::set<std::array<float, 3>> places;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    places.insert({mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]});
  }
  return mesh.vertexCount() - places.size();
}

TEST_P(Adjacency, OfJoinedVerticesIsDecidedAlikeInEveryCycle) {
  std::mt19937 random(7);
  Scene scene = selfScene(clothWithJoinedVertices(random));
  for (int cycle = 0; cycle < 12; ++cycle) {
    const TriangleMesh mesh = clothWithJoinedVertices(random);
    ASSERT_LT(8 * repeatedVertices(mesh), mesh.vertexCount()) << "so few are no reason to search";
    scene.setVertices(0, mesh.vertices.data(), mesh.vertexCount());
    const AdjacentPairs adjacent = kBothAdjacent[cycle % 4 == 1 ? 0 : 1];
    const std::vector<TrianglePair> expected = oracleContacts(scene, adjacent);
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(samePairs(expected, contacts(scene, withAdjacent(adjacent)))) << "cycle " << cycle;
  }
}

// Two triangles folded onto each other along the edge that they share, and one whose vertex lies on
// both of them: each two of the three meet, and float32 is certain of none.
void addFold(const Vec3f& at, float size, TriangleMesh* mesh) {
  const auto first = static_cast<std::uint32_t>(mesh->vertexCount());
  for (const Vec3f& v : {Vec3f{0, 0, 0}, Vec3f{0, 1, 0}, Vec3f{1, 0.5F, 0}, Vec3f{1, 0.375F, 0},
                         Vec3f{0.25F, 0.5F, 0}, Vec3f{0.25F, 0.5F, 1}, Vec3f{0.5F, 0.75F, 1}}) {
    const Vec3f p = at + v * size;
    mesh->vertices.insert(mesh->vertices.end(), {p.x, p.y, p.z});
  }
  for (const std::uint32_t v : {0U, 1U, 2U, 0U, 1U, 3U, 4U, 5U, 6U}) {
    mesh->triangles.push_back(first + v);
  }
}

// However many others wait for their verdicts too. Some are much larger than the others.
TEST_P(Adjacency, EachOfManyFoldsMeets) {
  for (const std::uint32_t count : {1U, 700U, 2501U}) {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
      const bool large = i % 500 == 250;
      const Vec3f at{4.0F * static_cast<float>(i % 50), 4.0F * static_cast<float>(i / 50), 0};
      addFold(large ? Vec3f{at.x, at.y, 4096.0F * static_cast<float>(i)} : at, large ? 1024 : 1,
              &mesh);
    }
    std::vector<TrianglePair> expected;
    for (std::uint32_t t = 0; t < 3 * count; t += 3) {
      for (const auto& [a, b] : {std::pair(t, t + 1), std::pair(t, t + 2), std::pair(t + 1, t + 2)})
        expected.push_back({0, a, 0, b});
    }
    std::sort(expected.begin(), expected.end());
    const Scene scene = selfScene(mesh);
    for (int cycle = 0; cycle < 3; ++cycle) {
      EXPECT_TRUE(samePairs(expected, contacts(scene))) << count << " folds, cycle " << cycle;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, Adjacency, ::testing::ValuesIn(allBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
