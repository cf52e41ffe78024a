// A triangle of a scene's body, brought into the scene frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/predicates/vector3.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// A body's triangles in the scene frame. The body's mesh must be valid, and outlive this.
class PosedBody {
 public:
  explicit PosedBody(const Body& body) : body_(&body), identity_(body.pose.isIdentity()) {}

  // The three corners of one of its triangles [m], rounded as the detector does.
  std::array<Vec3f, 3> triangle(std::uint32_t t) const {
    std::array<Vec3f, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const float* v =
          &body_->mesh.vertices[3 * std::size_t{body_->mesh.triangles[3 * std::size_t{t} + i]}];
      const Vec3f vertex{v[0], v[1], v[2]};
      corners[i] = identity_ ? vertex : apply(body_->pose, vertex);
    }
    return corners;
  }

 private:
  const Body* body_;
  bool identity_;
};

// Twice the triangle's area times its unit normal (right-handed) [m^2].
inline Vec3d doubleAreaNormal(const std::array<Vec3f, 3>& t) {
  const Vec3d origin = toDouble(t[0]);
  return cross(toDouble(t[1]) - origin, toDouble(t[2]) - origin);
}

}  // namespace deformable_contact_monitor
