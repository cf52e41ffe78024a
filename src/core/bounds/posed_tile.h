// Holds one tile of a body in the scene frame, with the boxes that bound it. Oriented boxes are
// thin around a piece of a surface, unlike axis-aligned ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/common/posed_body.h"
#include "core/predicates/aabb.h"
#include "core/predicates/triangle.h"
#include "core/tiling.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// The set of all points centre + sum of s_k axis_k with |s_k| <= half_k, in real numbers. The axes
// are orthogonal unit vectors, up to an error of kAxisError.
struct OrientedBox {
  Vec3d centre;                // [m], scene frame
  Vec3d axis[3];               // the first is along the normal of a flat piece
  double half[3] = {0, 0, 0};  // [m]
};

constexpr double kAxisError = 1e-13;

// Returns a box of `count` >= 1 finite points. `normal` is the direction in which the box shall be
// thin, with any length; a zero vector lets the function choose.
OrientedBox orientedBoxOf(const float* x, const float* y, const float* z, std::size_t count,
                          const Vec3d& normal);

// Returns a lower bound of the distance between the points of two boxes [m]. It is 0 if they
// overlap, and may be 0 if they do not.
double lowerGap(const OrientedBox& a, const OrientedBox& b);

// Holds those of the tile's triangles whose posed vertices are finite. The others were rejected.
struct PosedTile {
  static constexpr std::size_t kTriangles = Tiling::kTileTriangles;

  std::size_t count = 0;                           // of triangles; 0: the other members are not set
  std::array<std::uint32_t, kTriangles> triangle;  // its index in the body
  std::array<std::array<std::uint8_t, 3>, kTriangles> corners;  // indices into x, y and z
  std::size_t vertex_count = 0;                                 // each is a vertex of some triangle
  std::array<float, 3 * kTriangles> x, y, z;                    // scene frame [m]
  Aabb box;                                                     // of the vertices
  OrientedBox oriented;                                         // of the vertices
  // Bounds of each triangle by axis. Entries beyond `count` repeat the last triangle's.
  std::array<std::array<float, kTriangles>, 3> low, high;

  // Return a vertex, and a triangle, by its place in this tile.
  Vec3f vertex(std::size_t i) const { return {x[i], y[i], z[i]}; }
  Triangle posed(std::size_t t) const {
    return {{vertex(corners[t][0]), vertex(corners[t][1]), vertex(corners[t][2])}};
  }

  // Reads and poses the vertices of a tile, and makes its boxes.
  void make(const Tiling& tiling, std::size_t tile, const PosedBody& body);

  // Does the same with a tile of up to kTriangles triangles of a mesh, from `first` on in its
  // order.
  void makeRun(const TriangleMesh& mesh, std::size_t first, const PosedBody& body);

 private:
  void finish(const std::uint32_t* vertices, const PosedBody& body);
  void dropRejected();
  void findBoxes();
};

}  // namespace deformable_contact_monitor
