// Compares the parts found inside closed surfaces with an oracle that casts rays in exact
// rationals. The bodies are random or real meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "containment_fixture.h"
#include "core/mesh_file.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

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
  if (below(12) == 0) {  // all of them, or some, once more or twice, turned around
    const std::size_t count = body.triangles.size();
    const unsigned share = 1 + below(3), times = 1 + below(2);
    for (std::size_t t = 0; t < count; t += 3) {
      for (unsigned k = below(share) == 0 ? times : 0; k > 0; --k) {
        for (const std::size_t corner : {1, 0, 2}) {
          body.triangles.push_back(body.triangles[t + corner]);
        }
      }
    }
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

}  // namespace
}  // namespace deformable_contact_monitor
