// Makes triangles between the neighbouring pixels of a depth camera.
#include "monitor/input/depth_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace deformable_contact_monitor {
namespace {

using Pixels = std::array<std::size_t, 3>;

// The squared depth of each pixel [m^2]; 0: it has none.
std::vector<double> squaredDepths(const std::vector<float>& coordinates) {
  std::vector<double> depths(coordinates.size() / 3);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const double x = coordinates[3 * i], y = coordinates[3 * i + 1], z = coordinates[3 * i + 2];
    const double squared = (x * x + y * y) + z * z;
    depths[i] = std::isfinite(squared) ? squared : 0;
  }
  return depths;
}

}  // namespace

DepthSurface depthSurface(const std::vector<float>& coordinates, std::size_t width,
                          std::size_t height, double max_depth_jump) {
  const std::vector<double> depths = squaredDepths(coordinates);
  const double most = (1 + max_depth_jump) * (1 + max_depth_jump);
  const auto isPossible = [&](const Pixels& pixels) {
    const auto [low, high] = std::minmax({depths[pixels[0]], depths[pixels[1]], depths[pixels[2]]});
    return low > 0 && high <= most * low;
  };
  DepthSurface surface;
  for (const double depth : depths) surface.pixels_with_depth += depth > 0;
  for (std::size_t row = 0; row + 1 < height; ++row) {
    for (std::size_t column = 0; column + 1 < width; ++column) {
      const std::size_t a = row * width + column, b = a + 1, c = a + width, d = c + 1;
      const Pixels divided[2][2] = {{{a, c, b}, {b, c, d}}, {{a, c, d}, {a, d, b}}};
      const bool is_possible[2][2] = {{isPossible(divided[0][0]), isPossible(divided[0][1])},
                                      {isPossible(divided[1][0]), isPossible(divided[1][1])}};
      const int best =
          is_possible[1][0] + is_possible[1][1] > is_possible[0][0] + is_possible[0][1];
      for (const int half : {0, 1}) {
        if (!is_possible[best][half]) continue;
        for (const std::size_t pixel : divided[best][half]) {
          surface.triangles.push_back(static_cast<std::uint32_t>(pixel));
        }
      }
    }
  }
  return surface;
}

}  // namespace deformable_contact_monitor
