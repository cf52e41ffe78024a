// Provides a fixture with a ContainmentFinder and its detector, and closed meshes, for tests of
// containment.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "containment_oracle.h"
#include "core/analysis/containment.h"
#include "core/cpu_detector.h"

namespace deformable_contact_monitor {

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
inline TriangleMesh cubesSurface(int n, const std::vector<bool>& full, std::mt19937* random) {
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

inline TriangleMesh box(float x, float y, float z, float size_x, float size_y, float size_z) {
  TriangleMesh mesh = cubesSurface(1, {true}, nullptr);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    mesh.vertices[i] = x + size_x * mesh.vertices[i];
    mesh.vertices[i + 1] = y + size_y * mesh.vertices[i + 1];
    mesh.vertices[i + 2] = z + size_z * mesh.vertices[i + 2];
  }
  return mesh;
}

inline TriangleMesh cube(float at, float size) { return box(at, at, at, size, size, size); }

inline TriangleMesh tetrahedron(float x, float y, float z, float size) {
  return {{x, y, z, x + size, y, z, x, y + size, z, x, y, z + size},
          {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}};
}

inline void append(const TriangleMesh& more, TriangleMesh* mesh) {
  const auto first = static_cast<std::uint32_t>(mesh->vertexCount());
  mesh->vertices.insert(mesh->vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const std::uint32_t v : more.triangles) mesh->triangles.push_back(first + v);
}

inline TriangleMesh together(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh = a;
  append(b, &mesh);
  return mesh;
}

}  // namespace deformable_contact_monitor
