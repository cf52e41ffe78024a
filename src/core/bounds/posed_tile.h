// One tile of a body as it lies in the scene.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/bounds/oriented_box.h"
#include "core/common/posed_body.h"
#include "core/predicates/aabb.h"
#include "core/predicates/triangle.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// Its triangles whose posed vertices are finite; the others were rejected.
struct PosedTile {
  static constexpr std::size_t kTriangles = Tiling::kTileTriangles;

  std::size_t count = 0;                           // of triangles; 0: the rest is of no use
  std::array<std::uint32_t, kTriangles> triangle;  // which of the body's
  std::array<std::array<std::uint8_t, 3>, kTriangles> corners;  // places among the vertices
  std::size_t vertex_count = 0;                                 // all of some triangle
  std::array<float, 3 * kTriangles> x, y, z;                    // scene frame [m]
  Aabb box;                                                     // of them
  OrientedBox oriented;                                         // the same
  // Of each triangle, by axis; beyond `count` as the last one's.
  std::array<std::array<float, kTriangles>, 3> low, high;

  Vec3f vertex(std::size_t i) const { return {x[i], y[i], z[i]}; }
  Triangle posed(std::size_t t) const {
    return {{vertex(corners[t][0]), vertex(corners[t][1]), vertex(corners[t][2])}};
  }

  void make(const Tiling& tiling, std::size_t tile, const PosedBody& body);

 private:
  void takeAll(const Tiling& tiling, std::size_t tile);
  void takeFinite(const Tiling& tiling, std::size_t tile);
  void findBoxes();
};

}  // namespace deformable_contact_monitor
