// Vertices of a body in the scene frame.
#pragma once

#include "core/host_device.h"
#include "core/rigid_transform.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// float32(R v + t), in double, in this order: ((r0 x + r1 y) + r2 z) + t. Every backend, and every
// oracle, must round alike, so translation units that use it are built without FMA contraction.
DCM_HD inline Vec3f apply(const RigidTransform& pose, const Vec3f& v) {
  const double x = v.x, y = v.y, z = v.z;
  const double* r = pose.rotation;
  const double* t = pose.translation;
  return {static_cast<float>(((r[0] * x + r[1] * y) + r[2] * z) + t[0]),
          static_cast<float>(((r[3] * x + r[4] * y) + r[5] * z) + t[1]),
          static_cast<float>(((r[6] * x + r[7] * y) + r[8] * z) + t[2])};
}

// A body's vertex in the scene frame [m]; `identity`: pose.isIdentity(), which leaves it untouched,
// bit by bit.
DCM_HD inline Vec3f posedVertex(const RigidTransform& pose, bool identity, const Vec3f& v) {
  return identity ? v : apply(pose, v);
}

}  // namespace deformable_contact_monitor
