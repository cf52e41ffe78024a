// Rigid transforms, such as the pose of a body in the scene frame.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/export.h"

namespace deformable_contact_monitor {

// Transforms points: p_scene = rotation * p_body + translation. The rotation is row-major, the
// translation in [m].
struct DCM_EXPORT RigidTransform {
  double rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double translation[3] = {0, 0, 0};

  // Returns whether all numbers are exactly those of the identity; == compares as exactly.
  bool isIdentity() const { return *this == RigidTransform(); }

  bool operator==(const RigidTransform& o) const {
    return std::equal(rotation, rotation + 9, o.rotation) &&
           std::equal(translation, translation + 3, o.translation);
  }
};

// Returns how far a matrix is from a rotation or a mirroring: the Frobenius norm of R^T R minus the
// identity, which bounds its operator norm. The matrix is row-major.
inline double rotationDefect(const double r[9]) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double x = r[i] * r[j] + r[3 + i] * r[3 + j] + r[6 + i] * r[6 + j] - (i == j ? 1 : 0);
      sum += x * x;
    }
  }
  return std::sqrt(sum);
}

// Returns whether a matrix is a rotation, up to the roundings of callers: its defect is at most
// 1e-3, and its determinant is not negative, as that of a mirroring would be. False for NaN.
inline bool isRotation(const double r[9]) {
  const double determinant = r[0] * (r[4] * r[8] - r[5] * r[7]) -
                             r[1] * (r[3] * r[8] - r[5] * r[6]) +
                             r[2] * (r[3] * r[7] - r[4] * r[6]);
  return rotationDefect(r) <= 1e-3 && determinant > 0;
}

// Returns whether all numbers of a transform are finite.
inline bool isFinite(const RigidTransform& o) {
  const auto finite = [](double x) { return std::isfinite(x); };
  return std::all_of(o.rotation, o.rotation + 9, finite) &&
         std::all_of(o.translation, o.translation + 3, finite);
}

}  // namespace deformable_contact_monitor
