// Transforms a body's vertices into the scene frame.
#pragma once

#include "core/host_device.h"
#include "core/rigid_transform.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Returns float32(R v + t), computed in double in this order: ((r0 x + r1 y) + r2 z) + t. All
// backends and oracles must round alike, so that source files that use it are compiled without
// contraction to FMA.
DCM_HD inline Vec3f apply(const RigidTransform& pose, const Vec3f& v) {
  const double x = v.x, y = v.y, z = v.z;
  const double* r = pose.rotation;
  const double* t = pose.translation;
  return {toFloat(((r[0] * x + r[1] * y) + r[2] * z) + t[0]),
          toFloat(((r[3] * x + r[4] * y) + r[5] * z) + t[1]),
          toFloat(((r[6] * x + r[7] * y) + r[8] * z) + t[2])};
}

// Returns a body's vertex in the scene frame [m]. `identity` is pose.isIdentity(): then the vertex
// is unchanged, bit for bit.
DCM_HD inline Vec3f posedVertex(const RigidTransform& pose, bool identity, const Vec3f& v) {
  return identity ? v : apply(pose, v);
}

}  // namespace deformable_contact_monitor
