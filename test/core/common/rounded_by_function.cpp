// The same with the function that rounds whatever the flags are, and the pose of a vertex, which
// uses it. Compiled at -O3 without the project's flags, as code that includes its headers may be.
#include "core/rules/posed_vertex.h"
#include "core/vector3.h"
#include "rounded_lines.h"

namespace deformable_contact_monitor {

void roundTwoByFunction(const double* a, double* o) {
  float f = toFloat(a[0] * 3), g = toFloat(a[1] * 3);
  o[0] = f;
  o[1] = g;
}

void roundVector(const double* a, double* o) {
  const Vec3d v = toDouble(toFloat(Vec3d{a[0] * 3, a[1] * 3, a[2] * 3}));
  o[0] = v.x;
  o[1] = v.y;
  o[2] = v.z;
}

void poseVertex(const RigidTransform& pose, const Vec3f& vertex, double* o) {
  const Vec3d v = toDouble(apply(pose, vertex));
  o[0] = v.x;
  o[1] = v.y;
  o[2] = v.z;
}

}  // namespace deformable_contact_monitor
