// Which triangles are very large or far off. One such outlier must cost only itself: in clusters it
// would stretch the coordinates, turn the principal axes and belong everywhere. So it goes onto a
// list of its own, whose triangles are tested by boxes against the clusters and their members, and
// against each other (stage `large`).
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/predicates/aabb.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Everything is regular as constructed.
struct SizeRule {
  Vec3d origin;                                          // the middle of the scene [m]
  double most_extent = INFINITY, most_reach = INFINITY;  // [m]

  DCM_HD bool isLarge(const Aabb& box) const {
    const Vec3d lo = toDouble(box.min), hi = toDouble(box.max);
    const Vec3d a = lo - origin, b = hi - origin, size = hi - lo;
    const double extent = most(size.x, most(size.y, size.z));
    const double reach = most(most(most(fabs(a.x), fabs(b.x)), most(fabs(a.y), fabs(b.y))),
                              most(fabs(a.z), fabs(b.z)));
    return extent > most_extent || reach > most_reach;
  }
};

}  // namespace deformable_contact_monitor
