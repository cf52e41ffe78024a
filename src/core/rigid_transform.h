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

// Returns whether all numbers of a transform are finite.
inline bool isFinite(const RigidTransform& o) {
  const auto finite = [](double x) { return std::isfinite(x); };
  return std::all_of(o.rotation, o.rotation + 9, finite) &&
         std::all_of(o.translation, o.translation + 3, finite);
}

}  // namespace deformable_contact_monitor
