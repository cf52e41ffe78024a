// Boxes that lie as their points do: of a piece of a surface they are thin.
#pragma once

#include <cstddef>

#include "core/vector3.h"

namespace deformable_contact_monitor {

// All centre + sum of s_k axis_k with |s_k| <= half_k, in real numbers. The axes are unit vectors,
// orthogonal to one another, each but for kAxisError.
struct OrientedBox {
  Vec3d centre;                // [m], scene frame
  Vec3d axis[3];               // the first is about the normal of what is flat
  double half[3] = {0, 0, 0};  // [m]
};

constexpr double kAxisError = 1e-13;

// Of `count` >= 1 finite points. `normal`: the direction in which it is to be thin, of any length;
// 0: any.
OrientedBox orientedBoxOf(const float* x, const float* y, const float* z, std::size_t count,
                          const Vec3d& normal);

// No point of a is nearer to one of b [m].
double lowerGap(const OrientedBox& a, const OrientedBox& b);

}  // namespace deformable_contact_monitor
