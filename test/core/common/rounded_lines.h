// Functions that round to float32 and convert back to double. They are compiled in files of their
// own, with flags of their own.
#pragma once

#include "core/rigid_transform.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Write float32(3 a[i]) for two values; the third function for three.
void roundTwo(const double* a, double* o);
void roundTwoByFunction(const double* a, double* o);
void roundVector(const double* a, double* o);

// Writes the vertex in the scene frame.
void poseVertex(const RigidTransform& pose, const Vec3f& vertex, double* o);

}  // namespace deformable_contact_monitor
