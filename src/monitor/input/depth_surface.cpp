// Makes a mesh of the neighbouring pixels of a depth camera.
#include "monitor/input/depth_surface.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

namespace deformable_contact_monitor {
namespace {

// The image of a depth camera, with the triangles that were made of it.
class DepthImage {
 public:
  DepthImage(const std::vector<float>& coordinates, std::size_t width, std::size_t height,
             double max_depth_jump);

  void addTriangles();
  // Joins each pixel that is in no triangle to its neighbours of similar depth. Call it last.
  void addLonePixels();

  DepthSurface surface;

 private:
  using Pixels = std::initializer_list<std::size_t>;

  // Returns whether all of them have a depth, and the depths are similar.
  bool areSimilar(Pixels pixels) const {
    double low = depths_[*pixels.begin()], high = low;
    for (const std::size_t pixel : pixels) {
      low = std::min(low, depths_[pixel]);
      high = std::max(high, depths_[pixel]);
    }
    return low > 0 && high <= most_ * low;
  }

  void add(Pixels pixels) {
    for (const std::size_t pixel : pixels) {
      surface.triangles.push_back(static_cast<std::uint32_t>(pixel));
    }
  }

  void addLonePixel(std::size_t pixel, const std::vector<bool>& is_in_triangle);

  const std::size_t width_, height_;
  const double most_;           // largest ratio of the squares of similar depths
  std::vector<double> depths_;  // squares of the pixels' depths [m^2]; 0: it has none
};

DepthImage::DepthImage(const std::vector<float>& coordinates, std::size_t width, std::size_t height,
                       double max_depth_jump)
    : width_(width),
      height_(height),
      most_((1 + max_depth_jump) * (1 + max_depth_jump)),
      depths_(coordinates.size() / 3) {
  for (std::size_t i = 0; i < depths_.size(); ++i) {
    const double x = coordinates[3 * i], y = coordinates[3 * i + 1], z = coordinates[3 * i + 2];
    const double squared = (x * x + y * y) + z * z;
    depths_[i] = std::isfinite(squared) ? squared : 0;
    surface.pixels_with_depth += depths_[i] > 0;
  }
}

void DepthImage::addTriangles() {
  surface.triangles.reserve(6 * depths_.size());  // two for each pixel: growing takes far longer
  for (std::size_t row = 0; row + 1 < height_; ++row) {
    for (std::size_t column = 0; column + 1 < width_; ++column) {
      const std::size_t a = row * width_ + column, b = a + 1, c = a + width_, d = c + 1;
      const bool acb = areSimilar({a, c, b}), bcd = areSimilar({b, c, d});
      const bool acd = areSimilar({a, c, d}), adb = areSimilar({a, d, b});
      if (acd + adb > acb + bcd) {
        if (acd) add({a, c, d});
        if (adb) add({a, d, b});
      } else {
        if (acb) add({a, c, b});
        if (bcd) add({b, c, d});
      }
    }
  }
}

void DepthImage::addLonePixels() {
  std::vector<bool> is_in_triangle(depths_.size());
  for (const std::uint32_t pixel : surface.triangles) is_in_triangle[pixel] = true;
  for (std::size_t pixel = 0; pixel < depths_.size(); ++pixel) {
    if (depths_[pixel] > 0 && !is_in_triangle[pixel]) addLonePixel(pixel, is_in_triangle);
  }
}

void DepthImage::addLonePixel(std::size_t pixel, const std::vector<bool>& is_in_triangle) {
  const std::size_t row = pixel / width_, column = pixel % width_;
  bool is_joined = false;
  for (std::size_t y = row - (row > 0); y <= row + 1 && y < height_; ++y) {
    for (std::size_t x = column - (column > 0); x <= column + 1 && x < width_; ++x) {
      const std::size_t other = y * width_ + x;
      if (other == pixel || !areSimilar({pixel, other})) continue;
      is_joined = true;
      // Of two lone pixels, the first one makes the line.
      if (is_in_triangle[other] || pixel < other) add({pixel, other, other});
    }
  }
  if (!is_joined) add({pixel, pixel, pixel});
}

}  // namespace

DepthSurface depthSurface(const std::vector<float>& coordinates, std::size_t width,
                          std::size_t height, double max_depth_jump) {
  DepthImage image(coordinates, width, height, max_depth_jump);
  image.addTriangles();
  image.addLonePixels();
  return std::move(image.surface);
}

}  // namespace deformable_contact_monitor
