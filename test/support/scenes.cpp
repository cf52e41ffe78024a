// Builders of scenes and meshes for the tests.
#include "scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
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

TriangleMesh splitThreeByThree(const TriangleMesh& mesh) {
  TriangleMesh out;
  const auto at = [&mesh](std::uint32_t i) {
    return Vec3f{mesh.vertices[3 * i], mesh.vertices[3 * i + 1], mesh.vertices[3 * i + 2]};
  };
  const auto add = [&out](const Vec3f& v) {
    out.vertices.insert(out.vertices.end(), {v.x, v.y, v.z});
    return static_cast<std::uint32_t>(out.vertices.size() / 3 - 1);
  };
  out.vertices = mesh.vertices;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> thirds;  // from, to: nearer from
  const auto third = [&](std::uint32_t from, std::uint32_t to) {
    const auto [place, added] = thirds.emplace(std::make_pair(from, to), 0);
    if (added) place->second = add(at(from) * (2.0F / 3) + at(to) * (1.0F / 3));
    return place->second;
  };
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    const std::uint32_t* c = &mesh.triangles[3 * t];
    const std::uint32_t ab = third(c[0], c[1]), ba = third(c[1], c[0]);
    const std::uint32_t bc = third(c[1], c[2]), cb = third(c[2], c[1]);
    const std::uint32_t ca = third(c[2], c[0]), ac = third(c[0], c[2]);
    const std::uint32_t m = add((at(c[0]) + at(c[1]) + at(c[2])) * (1.0F / 3));
    for (const auto& piece : {std::array<std::uint32_t, 3>{c[0], ab, ac},
                              {ab, ba, m},
                              {ab, m, ac},
                              {ac, m, ca},
                              {ba, c[1], bc},
                              {ba, bc, m},
                              {m, bc, cb},
                              {m, cb, ca},
                              {ca, cb, c[2]}}) {
      out.triangles.insert(out.triangles.end(), piece.begin(), piece.end());
    }
  }
  return out;
}

TriangleMesh sizedTo(const TriangleMesh& mesh, std::size_t triangles) {
  TriangleMesh out;
  if (triangles < mesh.triangleCount()) {
    out.vertices = mesh.vertices;
    out.triangles.assign(mesh.triangles.begin(),
                         mesh.triangles.begin() + static_cast<std::ptrdiff_t>(3 * triangles));
    return out;
  }
  float low = INFINITY, high = -INFINITY;
  for (const float x : mesh.vertices) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
  const float step = 1.25F * (high - low);
  const std::size_t copies = (triangles + mesh.triangleCount() - 1) / mesh.triangleCount();
  const auto side = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(copies))));
  for (std::size_t k = 0; k < copies; ++k) {
    const auto first = static_cast<std::uint32_t>(out.vertices.size() / 3);
    const float shift[3] = {step * static_cast<float>(k % side),
                            step * static_cast<float>(k / side % side),
                            step * static_cast<float>(k / side / side)};
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      out.vertices.push_back(mesh.vertices[i] + shift[i % 3]);
    }
    for (const std::uint32_t corner : mesh.triangles) out.triangles.push_back(first + corner);
  }
  return out;
}

TriangleMesh sliverSoup(int along, int layers, int in_layer, float gap_m) {
  TriangleMesh mesh;
  for (int layer = 0; layer < layers; ++layer) {
    for (int i = 0; i < in_layer; ++i) {
      const float z = gap_m * static_cast<float>(2 * layer + along);
      const float side = static_cast<float>(i) / static_cast<float>(in_layer);
      const float step = 0.5F / static_cast<float>(in_layer);
      const float corners[3][2] = {{0, side}, {1, side}, {0.5F, side + step}};
      for (const auto& [far, across] : corners) {
        mesh.triangles.push_back(static_cast<std::uint32_t>(mesh.vertexCount()));
        const float x = along == 0 ? far : across, y = along == 0 ? across : far;
        mesh.vertices.insert(mesh.vertices.end(), {x, y, z});
      }
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
