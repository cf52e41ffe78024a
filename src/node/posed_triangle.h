// A triangle of a scene's body, brought into the scene frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/scene.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// The three corners of `triangle` of `body` in the scene frame [m], rounded as the detector does.
// The body's mesh must be valid and `triangle` one of it.
inline std::array<Vec3f, 3> posedTriangle(const Body& body, std::uint32_t triangle) {
  std::array<Vec3f, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const float* v =
        &body.mesh.vertices[3 * std::size_t{body.mesh.triangles[3 * std::size_t{triangle} + i]}];
    const Vec3f vertex{v[0], v[1], v[2]};
    corners[i] = body.pose.isIdentity() ? vertex : apply(body.pose, vertex);
  }
  return corners;
}

// Twice the triangle's area times its unit normal (right-handed) [m^2].
inline Vec3d doubleAreaNormal(const std::array<Vec3f, 3>& t) {
  const Vec3d origin = toDouble(t[0]);
  return cross(toDouble(t[1]) - origin, toDouble(t[2]) - origin);
}

}  // namespace deformable_contact_monitor
