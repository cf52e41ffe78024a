// Bounds points by oriented boxes. Around a piece of a surface they are thin, unlike axis-aligned
// boxes.
#pragma once

#include <cstddef>

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

}  // namespace deformable_contact_monitor
