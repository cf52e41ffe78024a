#include "moving_meshes.h"

#include <algorithm>
#include <stdexcept>

namespace deformable_contact_monitor {

std::vector<MovingTriangle> movingTriangles(const TriangleMesh& from, const TriangleMesh& to) {
  if (from.triangles != to.triangles) throw std::invalid_argument("not the same triangles");
  std::vector<MovingTriangle> moving;
  for (std::size_t t = 0; t < from.triangleCount(); ++t) {
    MovingTriangle triangle;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t vertex = from.triangles[3 * t + static_cast<std::size_t>(k)];
      triangle.from.v[k] = from.vertex(vertex);
      triangle.to.v[k] = to.vertex(vertex);
    }
    moving.push_back(triangle);
  }
  return moving;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> sweptBoxPairs(
    const std::vector<MovingTriangle>& triangles) {
  struct Entry {
    Aabb box;
    std::uint32_t index;
  };
  std::vector<Entry> entries;
  Aabb all;
  for (const MovingTriangle& triangle : triangles) {
    entries.push_back({sweptBox(boxOf(triangle)), static_cast<std::uint32_t>(entries.size())});
    all.include(entries.back().box);
  }
  const Vec3f size = all.max - all.min;
  const int axis = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  std::sort(entries.begin(), entries.end(),
            [axis](const Entry& a, const Entry& b) { return a.box.min[axis] < b.box.min[axis]; });
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const float end = entries[i].box.max[axis];
    for (std::size_t j = i + 1; j < entries.size() && entries[j].box.min[axis] <= end; ++j) {
      if (!intersects(entries[i].box, entries[j].box)) continue;
      pairs.emplace_back(std::min(entries[i].index, entries[j].index),
                         std::max(entries[i].index, entries[j].index));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace deformable_contact_monitor
