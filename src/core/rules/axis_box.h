// Boxes of triangles with 15 bits for each side, for the CUDA sweep. They have half the size of an
// Aabb, and two of them are compared by three subtractions.
#pragma once

#include <cstdint>

#include "core/predicates/aabb.h"
#include "core/rules/intervals.h"
#include "core/rules/scene_scale.h"

namespace deformable_contact_monitor {

// Maps coordinates [m] to 15 bits. Any frame gives correct results; a good one covers the scene.
struct AxisFrame {
  Quantiser along[3];

  AxisFrame() = default;
  explicit AxisFrame(const SceneScale& scale) {
    const double reach = 1 / scale.scale;
    const double middle[3] = {scale.origin.x, scale.origin.y, scale.origin.z};
    for (int k = 0; k < 3; ++k) along[k] = Quantiser::around(middle[k], reach);
  }
};

// A word for each axis: the least end, and in the upper half how far the greatest end is below
// 0x7fff. So the box of two boxes has the least of each half.
struct AxisBox {
  static constexpr std::uint32_t kNone = 0x7fff7fffU;
  std::uint32_t words[3] = {kNone, kNone, kNone};

  AxisBox() = default;  // what no points have: the least ends are above the greatest ones
  DCM_HD AxisBox(std::uint32_t x, std::uint32_t y, std::uint32_t z) : words{x, y, z} {}
  // The box must not be empty.
  DCM_HD AxisBox(const Aabb& box, const AxisFrame& frame)
      : words{word(frame.along[0], box.min.x, box.max.x),
              word(frame.along[1], box.min.y, box.max.y),
              word(frame.along[2], box.min.z, box.max.z)} {}

 private:
  DCM_HD static std::uint32_t word(const Quantiser& along, float min, float max) {
    return along(min) | (0x7fff - along(max)) << 16;
  }
};

// A box that is compared with many: its greatest ends, and in the upper halves how far the least
// ends are below 0x7fff, with guard bits.
struct TurnedAxisBox {
  std::uint32_t words[3];

  TurnedAxisBox() = default;
  DCM_HD explicit TurnedAxisBox(const AxisBox& box)
      : words{turned(box.words[0]), turned(box.words[1]), turned(box.words[2])} {}

 private:
  DCM_HD static std::uint32_t turned(std::uint32_t word) { return ~(word >> 16 | word << 16); }
};

// Returns false only if the boxes that were mapped are apart.
DCM_HD inline bool intersects(const TurnedAxisBox& a, const AxisBox& b) {
  return ((a.words[0] - b.words[0]) & (a.words[1] - b.words[1]) & (a.words[2] - b.words[2]) &
          kPackedGuard) == kPackedGuard;
}

}  // namespace deformable_contact_monitor
