// Two cloths that lie in each other over half of their area, for the benchmarks.
#pragma once

#include <cmath>
#include <cstddef>

#include "moving_scene.h"
#include "scenes.h"

namespace deformable_contact_monitor {

namespace detail {

// The regions along x, in the side of the cloth. In the first one both cloths have the same
// vertices. In the next two they lie in one plane, level and then sloping, but their triangles
// overlap. In the rest they cross.
constexpr float kEqualUntil = 0.25F, kLevelUntil = 0.375F, kSlopeUntil = 0.5F;

// Rounds to 2^-16 m, so that the slope's heights are exact.
inline float snapped(float x) { return std::round(x * 0x1p16F) * 0x1p-16F; }

// Returns the height of the cloth at a point [m]. `phase` tells the two cloths apart where they
// cross.
inline float layeredHeight(float x, float y, float phase) {
  if (x < kEqualUntil) return 0.03F * std::sin(25.1327412F * x) * std::cos(9 * y);
  if (x < kLevelUntil) return 0;
  const float slope = 0.5F * (x - kLevelUntil);
  if (x <= kSlopeUntil) return slope;
  const float along = x - kSlopeUntil;
  return 0.0625F + 0.03F * std::sin(12 * along) + 0.02F * std::sin(40 * along + phase * y);
}

// Returns a cloth of 1 m. The second one is shifted by a part of a square where the cloths lie in
// one plane.
inline TriangleMesh layeredCloth(int squares, bool second) {
  TriangleMesh mesh = clothGrid(squares, 1, 0, 0);
  const float shift = snapped(0.3F / static_cast<float>(squares));
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    float x = snapped(mesh.vertices[i]), y = snapped(mesh.vertices[i + 1]);
    if (second && x > kEqualUntil && x < kSlopeUntil) {
      x += shift;
      y += 2 * shift;
    }
    mesh.vertices[i] = x;
    mesh.vertices[i + 1] = y;
    mesh.vertices[i + 2] = layeredHeight(x, y, second ? 30.0F : 20.0F);
  }
  return mesh;
}

}  // namespace detail

// Two cloths of 2 squares^2 triangles each. A quarter of their triangles are equal bit by bit,
// another quarter are coplanar and overlap, and the others are apart or cross. In the second state
// the last half of body 0 is 2 mm higher.
inline MovingScene layeredCloths(int squares = 166) {
  const TriangleMesh first = detail::layeredCloth(squares, false);
  MovingScene moving{"layered cloth",
                     pairScene(first, detail::layeredCloth(squares, true)),
                     {first.vertices, first.vertices}};
  for (std::size_t i = 0; i < first.vertices.size(); i += 3) {
    if (first.vertices[i] > detail::kSlopeUntil) moving.state[1][i + 2] += 0.002F;
  }
  return moving;
}

}  // namespace deformable_contact_monitor
