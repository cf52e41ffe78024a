// Scenes whose nearest triangles are hard to tell, and a test that compares them with brute force.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <ostream>
#include <random>
#include <utility>
#include <vector>

#include "detector_suite.h"
#include "scenes.h"

namespace deformable_contact_monitor {

inline std::ostream& operator<<(std::ostream& out, const NearestPair& n) {
  return out << n.pair << " at " << std::hexfloat << n.distance_m << std::defaultfloat;
}

inline Options withNearest() {
  Options options;
  options.nearest = true;
  return options;
}

inline Scene within(float margin_m, Scene scene) {
  scene.setMargin(0, margin_m);
  return scene;
}

// The same triangles in another order.
inline TriangleMesh shuffled(TriangleMesh mesh, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (std::size_t i = mesh.triangleCount(); i > 1; --i) {
    const std::size_t j = random() % i;
    for (std::size_t k = 0; k < 3; ++k) {
      std::swap(mesh.triangles[3 * (i - 1) + k], mesh.triangles[3 * j + k]);
    }
  }
  return mesh;
}

inline TriangleMesh scaled(TriangleMesh mesh, int exponent) {
  for (float& x : mesh.vertices) x = std::ldexp(x, exponent);
  return mesh;
}

// The surface of the unit cube, n n squares a side, as separate triangles.
inline TriangleMesh cubeGrid(int n) {
  const TriangleMesh side = clothGrid(n, 1, 0, 0);
  std::vector<Triangle> triangles;
  for (int face = 0; face < 6; ++face) {
    for (std::size_t t = 0; t < side.triangleCount(); ++t) {
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        const float* v = &side.vertices[3 * std::size_t{side.triangles[3 * t + k]}];
        float at[3];
        at[face % 3] = face < 3 ? 0 : 1;
        at[(face + 1) % 3] = v[0];
        at[(face + 2) % 3] = v[1];
        triangle.v[k] = {at[0], at[1], at[2]};
      }
      triangles.push_back(triangle);
    }
  }
  return meshOf(triangles);
}

// Turns all bodies of a scene alike.
inline void turn(Scene& scene, int i) {
  const double a = 0.3 + 0.7 * i, b = 1.1 * i;
  const RigidTransform pose{
      {std::cos(a), -std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::sin(a),
       std::cos(a) * std::cos(b), -std::cos(a) * std::sin(b), 0, std::sin(b), std::cos(b)},
      {0.1 * i, -0.2, 0.05 * i}};
  for (BodyId id = 0; id < scene.bodyCount(); ++id) scene.setPose(id, pose);
}

// Moves the vertices of a flat grid up by some steps of float32.
inline void roughen(Scene& scene, BodyId id, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<float> vertices = scene.body(id).mesh.vertices;
  for (std::size_t i = 2; i < vertices.size(); i += 3) {
    for (std::size_t n = random() % 4; n > 0; --n) {
      vertices[i] = std::nextafter(vertices[i], INFINITY);
    }
  }
  scene.setVertices(id, vertices.data(), vertices.size() / 3);
}

// Two grids of 2 n n triangles, one over the other, whose distances differ by a ten millionth.
inline Scene almostTied(std::uint32_t seed, int n) {
  const float gap = 0.01F + 1e-4F * static_cast<float>(seed % 7);
  TriangleMesh low = clothGrid(n, 1, 0, 0), high = clothGrid(n - 5, 1, gap, 0);
  if (seed % 2 == 1) low = shuffled(low, seed);
  Scene scene = pairScene(std::move(low), std::move(high));
  roughen(scene, 1, seed);
  return scene;
}

class NearestTest : public ::testing::TestWithParam<Backend> {
 protected:
  // Expects what brute force finds, of a detector with a past, twice, and of one without. Returns
  // what brute force finds.
  std::vector<NearestPair> expectSame(const Scene& scene, const Options& options = withNearest()) {
    const std::vector<NearestPair> expected = exact_->detect(scene, options).nearest;
    for (int i = 0; i < 2; ++i) EXPECT_EQ(expected, detector_->detect(scene, options).nearest);
    EXPECT_EQ(expected, GetParam().make()->detect(scene, options).nearest);
    return expected;
  }

  std::unique_ptr<Detector> detector_ = GetParam().make();
  std::unique_ptr<Detector> exact_ = makeBruteForceDetector();
};

}  // namespace deformable_contact_monitor
