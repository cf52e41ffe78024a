#include "core/bounds/layout.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMostVertices = 3 * Tiling::kTileTriangles;

class TileWriter {
 public:
  TileWriter(const TriangleMesh& mesh, Tiling* tiling)
      : mesh_(mesh), tiling_(*tiling), place_(mesh.vertexCount(), kNone) {}

  void write(std::size_t tile) {
    const std::uint32_t begin = tiling_.tile_begin[tile], end = tiling_.tile_begin[tile + 1];
    count_ = 0;
    for (std::uint32_t slot = begin; slot < end; ++slot) {
      for (std::size_t k = 0; k < 3; ++k) collect(corner(slot, k));
    }
    std::sort(vertex_.begin(), vertex_.begin() + static_cast<std::ptrdiff_t>(count_));
    for (std::size_t i = 0; i < count_; ++i) place_[vertex_[i]] = static_cast<std::uint8_t>(i);
    writeSlots(begin, end);
    for (std::size_t i = 0; i < count_; ++i) {
      tiling_.vertex.push_back(vertex_[i]);
      place_[vertex_[i]] = kNone;
    }
    tiling_.vertex_begin.push_back(static_cast<std::uint32_t>(tiling_.vertex.size()));
  }

 private:
  static constexpr std::uint8_t kNone = 255;
  static_assert(kMostVertices <= kNone, "places have 8 bits");

  std::uint32_t corner(std::uint32_t slot, std::size_t k) const {
    return mesh_.triangles[3 * std::size_t{tiling_.triangle[slot]} + k];
  }

  void collect(std::uint32_t vertex) {
    if (place_[vertex] != kNone) return;
    place_[vertex] = 0;
    vertex_[count_++] = vertex;
  }

  void writeSlots(std::uint32_t begin, std::uint32_t end) {
    std::array<std::uint32_t, kMostVertices> around{};  // of each vertex: bits of its triangles
    for (std::uint32_t slot = begin; slot < end; ++slot) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint8_t place = place_[corner(slot, k)];
        tiling_.corners[slot][k] = place;
        around[place] |= std::uint32_t{1} << (slot - begin);
      }
    }
    for (std::uint32_t slot = begin; slot < end; ++slot) {
      const std::array<std::uint8_t, 3>& c = tiling_.corners[slot];
      tiling_.neighbours[slot] = around[c[0]] | around[c[1]] | around[c[2]];
    }
  }

  const TriangleMesh& mesh_;
  Tiling& tiling_;
  std::vector<std::uint8_t> place_;  // of each vertex of the mesh among the tile's
  std::array<std::uint32_t, kMostVertices> vertex_{};
  std::size_t count_ = 0;
};

}  // namespace

void layOut(const CycleLimit& limit, const TriangleMesh& mesh, Tiling* tiling) {
  constexpr std::uint64_t kPace = 1024;
  TileWriter writer(mesh, tiling);
  resizeWithin(limit, tiling->triangle.size(), tiling->corners);
  resizeWithin(limit, tiling->triangle.size(), tiling->neighbours);
  if (limit.wasOver()) return;
  tiling->vertex.reserve(tiling->triangle.size());
  tiling->vertex_begin.assign(1, 0);
  PacedLimit pace(limit, kPace);
  for (std::size_t tile = 0; tile < tiling->tileCount() && !pace.over(); ++tile) {
    writer.write(tile);
  }
}

}  // namespace deformable_contact_monitor
