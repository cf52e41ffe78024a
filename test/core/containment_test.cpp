// What lies within a closed surface, against rays in exact rationals.
#include "core/containment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>

#include "containment_oracle.h"
#include "core/cpu/cpu_detector.h"
#include "core/mesh_files/mesh_file.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

using Parts = std::vector<OraclePart>;

// The finder and the detector are kept, as in a monitor.
class Containments : public ::testing::Test {
 protected:
  const Containment& find(const Scene& scene) {
    return finder_.find(scene, detector_->detect(scene, Options()), noLimit());
  }

  Parts inside(const Scene& scene) {
    Parts parts;
    for (const InsidePart& part : find(scene).parts) {
      parts.push_back({part.inner, part.outer, part.triangle});
    }
    return parts;
  }

  const std::unique_ptr<Detector> detector_ = makeCpuDetector();
  ContainmentFinder finder_;
};

// The surface of the unit cubes of a grid that are full, not welded beyond single squares: every
// edge has an even number of triangles.
TriangleMesh cubesSurface(int n, const std::vector<bool>& full, std::mt19937* random) {
  TriangleMesh mesh;
  const auto isFull = [&](int x, int y, int z) {
    const auto in = [n](int i) { return i >= 0 && i < n; };
    return in(x) && in(y) && in(z) && full[(x * n + y) * n + z];
  };
  const auto addSquare = [&](std::array<int, 3> at, int axis) {
    const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
    for (int corner = 0; corner < 4; ++corner) {
      std::array<int, 3> v = at;
      v[(axis + 1) % 3] += corner % 2;
      v[(axis + 2) % 3] += corner / 2;
      for (const int x : v) mesh.vertices.push_back(static_cast<float>(x));
    }
    const bool other = random != nullptr && (*random)() % 2 == 0;
    for (const int k :
         other ? std::array<int, 6>{0, 1, 2, 1, 2, 3} : std::array<int, 6>{0, 1, 3, 0, 3, 2}) {
      mesh.triangles.push_back(first + static_cast<std::uint32_t>(k));
    }
  };
  for (int x = 0; x <= n; ++x) {
    for (int y = 0; y <= n; ++y) {
      for (int z = 0; z <= n; ++z) {
        if (isFull(x, y, z) != isFull(x - 1, y, z)) addSquare({x, y, z}, 0);
        if (isFull(x, y, z) != isFull(x, y - 1, z)) addSquare({x, y, z}, 1);
        if (isFull(x, y, z) != isFull(x, y, z - 1)) addSquare({x, y, z}, 2);
      }
    }
  }
  return mesh;
}

TriangleMesh box(float x, float y, float z, float size_x, float size_y, float size_z) {
  TriangleMesh mesh = cubesSurface(1, {true}, nullptr);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    mesh.vertices[i] = x + size_x * mesh.vertices[i];
    mesh.vertices[i + 1] = y + size_y * mesh.vertices[i + 1];
    mesh.vertices[i + 2] = z + size_z * mesh.vertices[i + 2];
  }
  return mesh;
}

TriangleMesh cube(float at, float size) { return box(at, at, at, size, size, size); }

TriangleMesh tetrahedron(float x, float y, float z, float size) {
  return {{x, y, z, x + size, y, z, x, y + size, z, x, y, z + size},
          {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}};
}

void append(const TriangleMesh& more, TriangleMesh* mesh) {
  const auto first = static_cast<std::uint32_t>(mesh->vertexCount());
  mesh->vertices.insert(mesh->vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const std::uint32_t v : more.triangles) mesh->triangles.push_back(first + v);
}

TriangleMesh together(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh = a;
  append(b, &mesh);
  return mesh;
}

TEST_F(Containments, ACubeWithinACubeEitherWay) {
  EXPECT_EQ(inside(pairScene(cube(1, 1), cube(0, 3))), (Parts{{0, 1, 0}}));
  EXPECT_EQ(inside(pairScene(cube(0, 3), cube(1, 1))), (Parts{{1, 0, 0}}));
  EXPECT_EQ(inside(pairScene(cube(5, 1), cube(0, 3))), Parts());
  EXPECT_EQ(inside(pairScene(cube(0, 3), cube(0, 3))), Parts()) << "they touch";
  EXPECT_EQ(inside(pairScene(cube(0, 1), cube(0, 3))), Parts()) << "they touch";
}

TEST_F(Containments, TheCentroidIsTheMeanOfTheCorners) {
  const Scene scene = pairScene(box(1, 2, 3, 1, 1, 1), cube(0, 9));
  const Containment& found = find(scene);
  ASSERT_EQ(found.parts.size(), 1U);
  EXPECT_NEAR(found.parts[0].centroid.x, 1.5, 0.2);
  EXPECT_NEAR(found.parts[0].centroid.y, 2.5, 0.2);
  EXPECT_NEAR(found.parts[0].centroid.z, 3.5, 0.2);
}

TEST_F(Containments, ARayThroughVerticesAndAlongFacesIsDecided) {
  // Apexes above each other, faces and edges in one vertical plane.
  for (const float x : {0.25F, 0.5F, 1.0F}) {
    for (const float y : {0.25F, 0.5F, 1.0F}) {
      const Scene scene = pairScene(tetrahedron(x, y, 0.5F, 0.125F), cube(0, 2));
      EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}})) << x << ", " << y;
    }
  }
}

TEST_F(Containments, AnOpenBoxHoldsNothingAndIsSaid) {
  TriangleMesh open = cube(0, 3);
  open.triangles.resize(open.triangles.size() - 3);
  const Scene scene = pairScene(cube(1, 1), open);
  const Containment& found = find(scene);
  EXPECT_TRUE(found.parts.empty());
  EXPECT_EQ(found.bodies[0].open, 0U);
  EXPECT_EQ(found.bodies[1].open, 1U);
  EXPECT_EQ(found.bodies[1].all, 1U);
  EXPECT_TRUE(found.bodies[1].looked_at);
}

TEST_F(Containments, AClosedComponentHoldsBesideAnOpenOne) {
  const Scene scene = pairScene(cube(1, 1), together(clothGrid(2, 1, 9, 0), cube(0, 3)));
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}}));
  EXPECT_EQ(find(scene).bodies[1].open, 1U);
  EXPECT_EQ(find(scene).bodies[1].all, 2U);
}

TEST_F(Containments, EachPartByItself) {
  const TriangleMesh parts = together(together(cube(-5, 1), cube(1, 1)), cube(2.5F, 1));
  const Scene scene = pairScene(parts, cube(0, 3));  // outside, within, through a wall
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 12}}));
}

// Each of two shells is a closed component of its own: what is in both is inside.
TEST_F(Containments, NestedShellsEachCount) {
  const Scene scene = pairScene(cube(3, 1), together(cube(0, 9), cube(2, 3)));
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}}));
}

TEST_F(Containments, ClothsAndSoupsAreWithin) {
  EXPECT_EQ(inside(pairScene(clothGrid(4, 1, 1, 0.1F), cube(-1, 5))), (Parts{{0, 1, 0}}));
  Scene scene = pairScene(soupOf(cube(1, 1)), soupOf(cube(0, 3)));
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}}));
}

TEST_F(Containments, DuplicatedTrianglesCountModuloTwo) {
  const TriangleMesh hollow = cube(0, 3);
  const TriangleMesh twice = together(hollow, hollow);
  EXPECT_EQ(inside(pairScene(cube(1, 1), twice)), Parts()) << "every wall is two";
  EXPECT_EQ(inside(pairScene(cube(1, 1), together(twice, hollow))), (Parts{{0, 1, 0}}));
}

TEST_F(Containments, ARejectedVertexOpensItsComponentAlone) {
  TriangleMesh broken = cube(0, 3);
  broken.vertices[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(inside(pairScene(cube(1, 1), broken)), Parts());
  EXPECT_EQ(inside(pairScene(cube(1, 1), together(broken, cube(-1, 5)))), (Parts{{0, 1, 0}}));
  // One that only hangs on an edge, too: who knows what it closes, or leaves open.
  TriangleMesh fin = cube(0, 3);
  fin.vertices.insert(fin.vertices.end(), 3, std::numeric_limits<float>::quiet_NaN());
  fin.triangles.insert(fin.triangles.end(), {0, 1, 24});
  EXPECT_EQ(inside(pairScene(cube(1, 1), fin)), Parts());
  // Of a part within: what is left of it still is.
  TriangleMesh part = cube(1, 1);
  part.vertices[0] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(inside(pairScene(part, cube(0, 3))).empty());
}

TEST_F(Containments, FarAwayAndTiny) {
  for (const float scale : {1e-44F, 1e-30F, 1e20F, 1e37F}) {
    EXPECT_EQ(inside(pairScene(cube(2 * scale, scale), cube(0, 8 * scale))), (Parts{{0, 1, 0}}))
        << scale;
  }
  EXPECT_EQ(inside(pairScene(cube(1e7F + 2, 1), cube(1e7F, 8))), (Parts{{0, 1, 0}}));
  EXPECT_EQ(inside(pairScene(cube(1, 1), cube(-1e38F, 2e38F))), (Parts{{0, 1, 0}}));
}

TEST_F(Containments, PosesCountAndInfiniteOnesHoldNothing) {
  Scene scene = pairScene(cube(0, 1), cube(0, 3));
  RigidTransform pose;
  pose.translation[0] = pose.translation[1] = pose.translation[2] = 1;
  scene.setPose(0, pose);
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}}));
  pose.translation[0] = 10;
  scene.setPose(0, pose);
  EXPECT_EQ(inside(scene), Parts());
  pose.translation[0] = 1e300;
  scene.setPose(0, pose);
  EXPECT_EQ(inside(scene), Parts());
}

TEST_F(Containments, OnlyEnabledPairsAreLookedAt) {
  Scene scene = pairScene(cube(1, 1), cube(0, 3));
  scene.setPairEnabled(0, 1, false);
  EXPECT_EQ(inside(scene), Parts());
  EXPECT_FALSE(find(scene).bodies[0].looked_at);
}

// The mesh changes from cycle to cycle: its vertices, which of them are equal, its triangles.
TEST_F(Containments, FollowsChanges) {
  Scene scene = pairScene(cube(1, 1), cube(0, 3));
  EXPECT_EQ(inside(scene).size(), 1U);
  std::vector<float> moved = cube(5, 1).vertices;
  scene.setVertices(0, moved.data(), moved.size() / 3);
  EXPECT_EQ(inside(scene).size(), 0U);
  moved = cube(0.5F, 1).vertices;
  scene.setVertices(0, moved.data(), moved.size() / 3);
  EXPECT_EQ(inside(scene).size(), 1U);
  std::vector<float> torn = cube(0, 3).vertices;
  torn[0] += 0.125F;  // one corner of one square
  scene.setVertices(1, torn.data(), torn.size() / 3);
  EXPECT_EQ(inside(scene).size(), 0U);
  EXPECT_EQ(find(scene).bodies[1].open, 1U);
  scene.setMesh(1, cube(0, 3));
  EXPECT_EQ(inside(scene).size(), 1U);
}

TEST_F(Containments, ALimitThatIsOverIsSaid) {
  const Scene scene = pairScene(cube(1, 1), cube(0, 3));
  const std::atomic<bool> stop{true};
  Limits limits;
  limits.stop = &stop;
  const DetectionResult& result = detector_->detect(scene, Options());
  EXPECT_EQ(finder_.find(scene, result, CycleLimit(limits)).cut_off_because, "stopped");
  EXPECT_EQ(inside(scene).size(), 1U) << "the next cycle is as any";
  EXPECT_EQ(find(scene).cut_off_because, "");
}

// Parts and shells on small grids, where rays run through vertices and along edges and faces.
TriangleMesh randomBody(bool small, std::mt19937* random) {
  const auto below = [random](unsigned n) { return (*random)() % n; };
  TriangleMesh body;
  const unsigned parts = 1 + below(small ? 6 : 3);
  for (unsigned i = 0; i < parts; ++i) {
    TriangleMesh part;
    if (below(2) == 0) {
      std::vector<bool> full(27);
      for (std::size_t k = 0; k < full.size(); ++k) full[k] = below(3) > 0;
      part = cubesSurface(3, full, random);
    } else {
      part = tetrahedron(0, 0, 0, 1);
      for (float& x : part.vertices) x *= static_cast<float>(1 + below(3));
    }
    const float s = small ? 0.125F * static_cast<float>(1 + below(3)) : 2.0F * (1 + below(2));
    const auto place = [&] { return 0.5F * static_cast<float>(below(small ? 25 : 5)); };
    const float at[3] = {place(), place(), place()};
    for (std::size_t k = 0; k < part.vertices.size(); ++k) {
      part.vertices[k] = s * part.vertices[k] + at[k % 3];
    }
    append(part, &body);
  }
  if (below(4) == 0) body = soupOf(body);
  if (below(8) == 0 && body.triangles.size() > 3) body.triangles.resize(body.triangles.size() - 3);
  if (below(8) == 0) {  // a triangle again, and one of two equal corners
    const std::size_t t = 3 * below(static_cast<unsigned>(body.triangleCount()));
    for (int k = 0; k < 3; ++k) body.triangles.push_back(body.triangles[t + k]);
    for (const int k : {0, 1, 1}) body.triangles.push_back(body.triangles[t + k]);
  }
  if (below(10) == 0) body.vertices[below(static_cast<unsigned>(body.vertices.size()))] = NAN;
  for (float& x : body.vertices) {
    if (x == 0 && below(2) == 0) x = -0.0F;
  }
  return body;
}

class RandomContainments : public Containments,
                           public ::testing::WithParamInterface<std::uint32_t> {};

TEST_P(RandomContainments, EqualTheOracle) {
  std::mt19937 random(GetParam());
  std::size_t found = 0;
  for (int i = 0; i < 250; ++i) {
    const bool first_is_small = random() % 2 == 0;
    Scene scene = pairScene(randomBody(first_is_small, &random),
                            randomBody(!first_is_small || random() % 8 == 0, &random));
    const float scale[] = {1, 1, 1, 0x1p-140F, 0x1p100F, 0.1F};
    const float s = scale[random() % 6];
    const bool far = random() % 5 == 0 && s == 1;
    for (BodyId id = 0; id < 2; ++id) {
      std::vector<float> xyz = scene.body(id).mesh.vertices;
      for (float& x : xyz) x = far ? x + 0x1p19F : x * s;
      scene.setVertices(id, xyz.data(), xyz.size() / 3);
    }
    if (random() % 5 == 0) {
      RigidTransform pose{{0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 1}, {0.1, 0.2, 0.3}};
      scene.setPose(0, pose);
      if (random() % 2 == 0) scene.setPose(1, pose);
    }
    const Parts expected = oracleInside(scene);
    ASSERT_EQ(inside(scene), expected) << "scene " << i;
    found += expected.size();
  }
  EXPECT_GT(found, 50U);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomContainments, ::testing::Range(1U, 9U));

TEST_F(Containments, RealMeshes) {
  DCM_REQUIRE_TEST_DATA();
  for (const char* name :
       {"two_spheres.stl", "three_cubes.stl", "boxedSphere.stl", "sphere.stl", "unit_cube.stl",
        "unit_sphere.stl", "tetrahedron.stl", "cap.stl", "flat_eight_point_star.stl"}) {
    const TriangleMesh mesh = readMeshFile(testDataFile(std::string("hard-meshes/") + name));
    std::array<float, 3> low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      low[i % 3] = std::min(low[i % 3], mesh.vertices[i]);
      high[i % 3] = std::max(high[i % 3], mesh.vertices[i]);
    }
    // Small tetrahedra throughout its box, also below and above its vertices.
    TriangleMesh parts;
    std::mt19937 random(3);
    const float size = 0.01F * (high[0] - low[0]);
    for (int i = 0; i < 20; ++i) {
      float at[3];
      const std::size_t v = random() % mesh.vertexCount();
      for (int k = 0; k < 3; ++k) {
        const float share = static_cast<float>(random() % 1000) / 999;
        at[k] =
            i % 2 == 0 && k < 2 ? mesh.vertices[3 * v + k] : low[k] + share * (high[k] - low[k]);
      }
      append(tetrahedron(at[0], at[1], at[2], size), &parts);
    }
    const Scene scene = pairScene(parts, mesh);
    const Parts expected = oracleInside(scene);
    EXPECT_EQ(inside(scene), expected) << name;
    RecordProperty(name, static_cast<int>(expected.size()));
  }
}

// Many small parts in one large surface of many triangles: a bound for what
// would take minutes, were each part held against each triangle.
TEST_F(Containments, ManyPartsInOneSurface) {
  TriangleMesh parts;
  constexpr int kSide = 46;  // 97 336 of them
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    append(tetrahedron(static_cast<float>(i % kSide), static_cast<float>(i / kSide % kSide),
                       static_cast<float>(i / kSide / kSide), 0.25F),
           &parts);
  }
  TriangleMesh fine = cube(-10, 70);
  for (int k = 0; k < 4; ++k) fine = splitThreeByThree(fine);  // 78 732 triangles
  Scene scene;
  const BodyId a = scene.addBody("parts", parts), b = scene.addBody("shell", fine);
  scene.setPairEnabled(a, b, true);
  DetectionResult none;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(finder_.find(scene, none, noLimit()).parts.size(), std::size_t{97336});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

}  // namespace
}  // namespace deformable_contact_monitor
