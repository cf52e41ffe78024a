// Rigid transforms, such as the pose of a body in the scene frame.
#pragma once

#include "core/export.h"

namespace deformable_contact_monitor {

// Transforms points: p_scene = rotation * p_body + translation. The rotation is row-major, the
// translation in [m].
struct DCM_EXPORT RigidTransform {
  double rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double translation[3] = {0, 0, 0};

  // Returns whether all numbers are exactly those of the identity.
  bool isIdentity() const {
    constexpr double kIdentity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int i = 0; i < 9; ++i) {
      if (rotation[i] != kIdentity[i]) return false;
    }
    return translation[0] == 0 && translation[1] == 0 && translation[2] == 0;
  }
};

}  // namespace deformable_contact_monitor
