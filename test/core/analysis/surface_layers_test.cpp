// Tests containment in meshes that have triangles more than once, as exporters of double-sided
// surfaces write them, and what the definitions say of surfaces that meet, nest and overlap.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "containment_fixture.h"
#include "core/analysis/mesh_components.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

using Quads = std::vector<std::array<std::uint32_t, 4>>;

// Returns the mesh with its triangles in the other orientation.
TriangleMesh reversed(TriangleMesh mesh) {
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::swap(mesh.triangles[i], mesh.triangles[i + 1]);
  }
  return mesh;
}

// Returns the mesh with triangle t written again, turned and rotated at random.
void copyTriangle(std::size_t t, std::mt19937* random, TriangleMesh* mesh) {
  std::array<std::uint32_t, 3> c{mesh->triangles[3 * t], mesh->triangles[3 * t + 1],
                                 mesh->triangles[3 * t + 2]};
  std::shuffle(c.begin(), c.end(), *random);
  mesh->triangles.insert(mesh->triangles.end(), c.begin(), c.end());
}

// Triangulates the faces as a fan of the first vertex of each, as files of polygons are read. The
// other side of a face begins with its last vertex, so that it has the other diagonal.
TriangleMesh fanned(const std::vector<float>& vertices, const Quads& faces, bool both_sides) {
  TriangleMesh mesh{vertices, {}};
  for (const auto& f : faces) {
    mesh.triangles.insert(mesh.triangles.end(), {f[0], f[1], f[2], f[0], f[2], f[3]});
    if (!both_sides) continue;
    mesh.triangles.insert(mesh.triangles.end(), {f[3], f[2], f[1], f[3], f[1], f[0]});
  }
  return mesh;
}

const Quads& cubeFaces() {
  static const Quads kFaces{{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                            {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  return kFaces;
}

std::vector<float> cubeCorners(float at, float size) {
  std::vector<float> vertices;
  for (int i = 0; i < 8; ++i) {
    for (const int bit : {4, 2, 1}) vertices.push_back(at + ((i & bit) != 0 ? size : 0));
  }
  return vertices;
}

class Layers : public Containments {
 protected:
  // Returns whether the container holds a small cube at (x, x, x).
  bool holds(const TriangleMesh& container, float x = 1) {
    return !inside(pairScene(cube(x, 0.25F), container)).empty();
  }
  // Returns how many of its parts are not closed.
  std::uint32_t openParts(const TriangleMesh& container) {
    return find(pairScene(cube(1, 0.25F), container)).bodies[1].open;
  }
};

TEST_F(Layers, ADoubleSidedMeshHoldsWhatTheSingleOneDoes) {
  const TriangleMesh single = cube(0, 3), back = reversed(single);
  const std::vector<TriangleMesh> doubled{together(single, back), together(single, single),
                                          soupOf(together(single, back)),
                                          together(together(single, back), single),
                                          together(together(single, back), together(single, back))};
  for (const TriangleMesh& mesh : doubled) {
    const std::size_t times = mesh.triangleCount() / single.triangleCount();
    EXPECT_TRUE(holds(mesh)) << times << " times";
    EXPECT_FALSE(holds(mesh, 5)) << times << " times";
    EXPECT_EQ(openParts(mesh), 0U) << times << " times";
  }
  // The vertices of both sides are the same.
  TriangleMesh shared = single;
  for (std::size_t t = 0; t < single.triangleCount(); ++t) {
    shared.triangles.insert(shared.triangles.end(), &back.triangles[3 * t],
                            &back.triangles[3 * t] + 3);
  }
  EXPECT_TRUE(holds(shared));
  // The part that is inside may be double-sided too.
  EXPECT_EQ(inside(pairScene(together(cube(1, 1), reversed(cube(1, 1))), together(single, back))),
            (Parts{{0, 1, 0}}));
}

TEST_F(Layers, FacesThatAreDividedInTwoWaysAreTwoSides) {
  EXPECT_TRUE(holds(fanned(cubeCorners(0, 3), cubeFaces(), false)));
  const TriangleMesh doubled = fanned(cubeCorners(0, 3), cubeFaces(), true);
  EXPECT_TRUE(holds(doubled));
  EXPECT_FALSE(holds(doubled, 5));
  EXPECT_EQ(openParts(doubled), 0U);
  EXPECT_TRUE(holds(together(doubled, reversed(cube(0, 3))))) << "three times";
  // Faces that are not planar: their two divisions enclose a little.
  std::vector<float> bent = cubeCorners(0, 3);
  bent[0] -= 0.5F;
  bent[22] += 0.25F;
  EXPECT_TRUE(holds(fanned(bent, cubeFaces(), true)));
  // One face alone has another side.
  TriangleMesh one = fanned(cubeCorners(0, 3), cubeFaces(), false);
  one.triangles.insert(one.triangles.end(), {2, 3, 1, 2, 1, 0});
  EXPECT_TRUE(holds(one));
}

TEST_F(Layers, SomeTrianglesMayBeThereMoreOften) {
  std::mt19937 random(1);
  const std::vector<TriangleMesh> meshes{cube(0, 3), tetrahedron(0, 0, 0, 12),
                                         splitThreeByThree(cube(0, 3))};
  for (int i = 0; i < 60; ++i) {
    const TriangleMesh& single = meshes[static_cast<std::size_t>(i) % meshes.size()];
    TriangleMesh mesh = single;
    const unsigned most = 1 + random() % 4, share = 1 + random() % 4;
    for (std::size_t t = 0; t < single.triangleCount(); ++t) {
      if (random() % share != 0) continue;
      for (unsigned k = random() % most; k > 0; --k) copyTriangle(t, &random, &mesh);
    }
    if (i % 4 == 0) mesh = soupOf(mesh);
    EXPECT_TRUE(holds(mesh)) << i;
    EXPECT_FALSE(holds(mesh, 9)) << i;
    EXPECT_EQ(openParts(mesh), 0U) << i;
  }
}

TEST_F(Layers, AnOpenMeshStaysOpenHoweverOftenItIsThere) {
  std::mt19937 random(2);
  TriangleMesh open = cube(0, 3);
  open.triangles.resize(open.triangles.size() - 3);
  const std::vector<TriangleMesh> meshes{
      together(open, open), together(open, reversed(open)), together(together(open, open), open),
      together(clothGrid(2, 1, 0, 0), reversed(clothGrid(2, 1, 0, 0)))};
  for (const TriangleMesh& mesh : meshes) {
    EXPECT_FALSE(holds(mesh));
    EXPECT_EQ(openParts(mesh), 1U);
  }
  TriangleMesh some = open;
  for (const std::size_t t : {0U, 3U, 7U}) copyTriangle(t, &random, &some);
  EXPECT_FALSE(holds(some));
  EXPECT_EQ(openParts(some), 1U);
}

// The wall between them is there once for each box.
TEST_F(Layers, BoxesThatShareAWallHoldInBoth) {
  const TriangleMesh boxes = together(box(0, 0, 0, 2, 3, 3), box(2, 0, 0, 2, 3, 3));
  const TriangleMesh twice = together(boxes, reversed(boxes));
  TriangleMesh open = boxes;
  open.triangles.erase(open.triangles.begin() + 3, open.triangles.begin() + 6);
  for (const TriangleMesh& mesh : {boxes, twice, together(twice, boxes), together(twice, twice)}) {
    for (const float x : {0.5F, 2.5F}) {
      EXPECT_EQ(inside(pairScene(box(x, 1, 1, 0.25F, 1, 1), mesh)), (Parts{{0, 1, 0}})) << x;
    }
    EXPECT_EQ(inside(pairScene(box(5, 1, 1, 0.25F, 1, 1), mesh)), Parts());
    EXPECT_EQ(openParts(mesh), 0U);
  }
  for (const TriangleMesh& mesh : {open, together(open, reversed(open))}) {
    EXPECT_EQ(openParts(mesh), 1U);
  }
}

// A label of two sides that hangs on an edge encloses nothing, and opens nothing.
TEST_F(Layers, ADoubleSidedFlapOpensNothing) {
  TriangleMesh mesh = cube(0, 3);
  const auto v = static_cast<std::uint32_t>(mesh.vertexCount());
  mesh.vertices.insert(mesh.vertices.end(),
                       {mesh.vertices[0], mesh.vertices[1], mesh.vertices[2], mesh.vertices[3],
                        mesh.vertices[4], mesh.vertices[5], -4, -4, -4});
  mesh.triangles.insert(mesh.triangles.end(), {v, v + 1, v + 2, v + 1, v, v + 2});
  EXPECT_TRUE(holds(mesh));
  EXPECT_EQ(openParts(mesh), 0U);
  mesh.triangles.resize(mesh.triangles.size() - 3);
  EXPECT_FALSE(holds(mesh));
  EXPECT_EQ(openParts(mesh), 1U);
}

// Boxes that share an edge are one component, in which parity decides. Boxes that share nothing, or
// a vertex, are components, and each counts by itself.
TEST_F(Layers, BoxesThatShareAnEdgeAreOneComponent) {
  const TriangleMesh diagonal = together(box(0, 0, 0, 2, 2, 4), box(2, 2, 0, 2, 2, 4));
  for (const float x : {0.5F, 2.5F}) {
    EXPECT_EQ(inside(pairScene(cube(x, 1), diagonal)), (Parts{{0, 1, 0}})) << x;
  }
  EXPECT_EQ(find(pairScene(cube(1, 1), diagonal)).bodies[1].all, 1U);
  // The lesser box lies within the greater one.
  const TriangleMesh nested = together(box(0, 0, 0, 4, 4, 4), box(0, 0, 0, 2, 2, 4));
  EXPECT_EQ(inside(pairScene(cube(2.5F, 1), nested)), (Parts{{0, 1, 0}})) << "in one";
  EXPECT_EQ(inside(pairScene(cube(0.5F, 1), nested)), Parts()) << "in both";
  EXPECT_EQ(openParts(nested), 0U);
  const TriangleMesh apart = together(box(0, 0, 0, 4, 4, 4), box(0.25F, 0.25F, 0.25F, 2, 2, 2));
  EXPECT_EQ(inside(pairScene(cube(0.5F, 1), apart)), (Parts{{0, 1, 0}})) << "two components";
}

TEST_F(Layers, WhatIsInTheCavityOfAHollowContainerIsInside) {
  const TriangleMesh hollow = together(cube(0, 9), reversed(cube(2, 5)));
  EXPECT_TRUE(holds(hollow, 4)) << "in the cavity";
  EXPECT_TRUE(holds(hollow, 1)) << "in the wall";
  EXPECT_TRUE(holds(together(hollow, reversed(hollow)), 4));
}

TEST_F(Layers, APartWithinTwoShellsIsListedForEachBody) {
  EXPECT_EQ(inside(pairScene(cube(3, 1), together(cube(0, 9), cube(2, 3)))), (Parts{{0, 1, 0}}));
  Scene scene;
  const BodyId part = scene.addBody("part", cube(3, 1)),
               lesser = scene.addBody("lesser", cube(2, 3)),
               greater = scene.addBody("greater", cube(0, 9));
  scene.setPairEnabled(part, lesser, true);
  scene.setPairEnabled(part, greater, true);
  scene.setPairEnabled(lesser, greater, true);
  EXPECT_EQ(inside(scene), (Parts{{0, 1, 0}, {0, 2, 0}, {1, 2, 0}}));
}

TEST_F(Layers, ARejectedVertexOpensADoubleSidedMesh) {
  TriangleMesh mesh = together(cube(0, 3), reversed(cube(0, 3)));
  mesh.vertices[0] = NAN;
  EXPECT_FALSE(holds(mesh));
  EXPECT_EQ(openParts(mesh), 1U);
}

}  // namespace
}  // namespace deformable_contact_monitor
