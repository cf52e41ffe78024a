// Triangles that are very large or far off, and the scale of all the others.
//
// One outlier must cost only itself: in clusters it would stretch the coordinates, turn the
// principal axes and belong everywhere. So it goes onto a list of its own, whose triangles are
// tested by boxes against the clusters and their members, and against each other.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/cpu/pose.h"
#include "core/predicates/host_device.h"
#include "core/rules/scene_scale.h"

namespace deformable_contact_monitor {

// What is very large, or far off the middle of the scene.
struct SizeRule {
  Vec3d origin;                                          // the middle
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

struct SizeSplit {
  std::vector<std::uint32_t> large;    // indices into the working set, ascending
  std::vector<std::uint32_t> regular;  // likewise
  SizeRule rule;                       // that told them apart
  SceneScale scale;                    // brings the regular triangles into [-1, 1]
};

// Large: 32 times the median extent, or 64 times the median distance from the middle of the scene.
// Where more than 64 and a 64th of the scene would be, the bounds are raised until it is not.
void splitBySize(const WorkingSet& set, SizeSplit& split);

}  // namespace deformable_contact_monitor
