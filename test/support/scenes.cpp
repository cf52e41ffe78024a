// Builders of scenes and meshes for the tests.
#include "scenes.h"

#include <cmath>
#include <utility>

namespace deformable_contact_monitor {

TriangleMesh meshOf(const std::vector<Triangle>& triangles) {
  TriangleMesh mesh;
  for (const Triangle& triangle : triangles) {
    for (const Vec3f& v : triangle.v) {
      mesh.triangles.push_back(static_cast<std::uint32_t>(mesh.vertexCount()));
      mesh.vertices.insert(mesh.vertices.end(), {v.x, v.y, v.z});
    }
  }
  return mesh;
}

TriangleMesh soupOf(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const std::uint32_t index : mesh.triangles) {
    const float* v = &mesh.vertices[3 * std::size_t{index}];
    soup.triangles.push_back(static_cast<std::uint32_t>(soup.vertexCount()));
    soup.vertices.insert(soup.vertices.end(), v, v + 3);
  }
  return soup;
}

TriangleMesh clothGrid(int n, float side, float height, float wave_height) {
  TriangleMesh mesh;
  const float step = side / static_cast<float>(n);
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const float x = step * static_cast<float>(i), y = step * static_cast<float>(j);
      const float wave = std::sin(12 * x / side) * std::cos(9 * y / side);
      mesh.vertices.insert(mesh.vertices.end(), {x, y, height + wave_height * wave});
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const auto a = static_cast<std::uint32_t>(i * (n + 1) + j);
      const std::uint32_t b = a + static_cast<std::uint32_t>(n) + 1;
      mesh.triangles.insert(mesh.triangles.end(), {a, b, b + 1, a, b + 1, a + 1});
    }
  }
  return mesh;
}

Scene selfScene(TriangleMesh mesh) {
  Scene scene;
  const BodyId id = scene.addBody("self", std::move(mesh));
  scene.setPairEnabled(id, id, true);
  return scene;
}

Scene pairScene(TriangleMesh a, TriangleMesh b) {
  Scene scene;
  const BodyId id_a = scene.addBody("a", std::move(a));
  const BodyId id_b = scene.addBody("b", std::move(b));
  scene.setPairEnabled(id_a, id_b, true);
  return scene;
}

}  // namespace deformable_contact_monitor
