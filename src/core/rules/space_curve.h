// The Hilbert curve through a cube of cells: positions that are near on it are near in space. Cells
// that follow each other share a side.
#pragma once

#include <cstdint>

#include "core/host_device.h"
#include "core/predicates/aabb.h"

namespace deformable_contact_monitor {

// Returns the position on the curve, less than 2^(3 kBits), of the cell with these coordinates,
// each less than 2^kBits. After J. Skilling, "Programming the Hilbert curve" (2004).
template <int kBits>
DCM_HD inline std::uint32_t placeOnCurve(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint32_t at[3] = {x, y, z};
  constexpr std::uint32_t kTop = 1U << (kBits - 1);
  for (std::uint32_t bit = kTop; bit > 1; bit >>= 1) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t swapped = (at[k] & bit) != 0 ? 0 : (at[0] ^ at[k]) & (bit - 1);
      at[0] ^= (at[k] & bit) != 0 ? bit - 1 : swapped;
      at[k] ^= swapped;
    }
  }
  at[1] ^= at[0];
  at[2] ^= at[1];
  std::uint32_t turned = 0;
  for (std::uint32_t bit = kTop; bit > 1; bit >>= 1) {
    if ((at[2] & bit) != 0) turned ^= bit - 1;
  }
  std::uint32_t place = 0;
  for (int b = kBits - 1; b >= 0; --b) {
    for (const std::uint32_t coordinate : at) place = place << 1 | ((coordinate ^ turned) >> b & 1);
  }
  return place;
}

constexpr int kCurveBits = 10;  // of each coordinate

// The cells of a box; all of them are cubes.
class CurveCells {
 public:
  DCM_HD explicit CurveCells(const Aabb& box) : least_(box.min * 0.5F) {
    const Vec3f half = box.max * 0.5F - least_;  // halves: the whole may have no float32
    cells_ = static_cast<float>(1U << kCurveBits) / fmaxf(half.x, fmaxf(half.y, half.z));
  }

  // Returns the position of the cell of a point. Any point is allowed, also one that is not finite.
  DCM_HD std::uint32_t placeOf(const Vec3f& p) const {
    const Vec3f from_least = p * 0.5F - least_;
    return placeOnCurve<kCurveBits>(cell(from_least.x), cell(from_least.y), cell(from_least.z));
  }

 private:
  DCM_HD std::uint32_t cell(float x) const {
    constexpr float kLast = (1U << kCurveBits) - 1;
    return static_cast<std::uint32_t>(fminf(fmaxf(x * cells_, 0.0F), kLast));  // NaN: 0
  }

  Vec3f least_;
  float cells_;
};

}  // namespace deformable_contact_monitor
