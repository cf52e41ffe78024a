// The path of a body in a time interval of continuous collision detection.
#pragma once

#include <vector>

#include "core/export.h"
#include "core/rigid_transform.h"

namespace deformable_contact_monitor {

// The pose of a body at one time. Times are parts of the interval, in [0, 1].
struct DCM_EXPORT PoseSample {
  double at;
  RigidTransform pose;
};

// The samples of a path, ascending; the first is at 0 and the last at 1. These two replace
// Body::earlier's pose and Body::pose. Between two samples the origin moves on a straight line, and
// the body rotates about one axis, by the smaller angle, both at constant speed (as tf2
// interpolates). If the body has earlier vertices, it deforms on the path: in its own frame they
// move straight to the present ones.
// An empty path: the vertices move straight in the scene frame, from the scene's earlier state to
// the present one.
using BodyPath = std::vector<PoseSample>;

}  // namespace deformable_contact_monitor
