// The surface that a depth camera saw: triangles between neighbouring pixels, and lines and points
// where it saw less.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace deformable_contact_monitor {

// A pixel has a depth if its coordinates are finite and not all zero. Its depth is its distance
// from the origin of the cloud's frame, which is the camera.
struct DepthSurface {
  std::vector<std::uint32_t> triangles;  // three pixels each, which count row by row
  std::size_t pixels_with_depth = 0;
};

// Makes triangles between the pixels of an image with these coordinates (x y z for each pixel).
//
// Depths of pixels are similar if all of them have one, and the largest is at most
// (1 + max_depth_jump) times the smallest one. This is computed in double, with squares:
// x * x + y * y + z * z on both sides. A triangle of three neighbouring pixels is possible if their
// depths are similar. Four neighbouring pixels are divided along the diagonal from the upper right
// to the lower left one; but along the other diagonal if more triangles are possible then.
// Triangles run counterclockwise as the camera sees them, where columns go right and rows go down.
//
// No pixel with a depth is lost. One that is in no triangle is joined by a line (the triangle
// i, j, j) to each of its eight neighbours of similar depth; without such a neighbour it is a point
// (i, i, i). These follow the triangles, by the pixel that is in none, then by the neighbour.
DepthSurface depthSurface(const std::vector<float>& coordinates, std::size_t width,
                          std::size_t height, double max_depth_jump);

}  // namespace deformable_contact_monitor
