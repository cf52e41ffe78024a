// Triangles that are very large or far off, and the scale of all the others.
//
// One outlier must cost only itself: in clusters it would stretch the coordinates, turn the
// principal axes and belong everywhere. So it goes onto a list of its own, whose triangles are
// tested by boxes against the clusters and their members, and against each other.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene_scale.h"
#include "core/working_set.h"

namespace deformable_contact_monitor {

struct SizeSplit {
  std::vector<std::uint32_t> large;    // indices into the working set, ascending
  std::vector<std::uint32_t> regular;  // likewise
  SceneScale scale;                    // brings the regular triangles into [-1, 1]
};

// Large: 32 times the median extent, or 64 times the median distance from the middle of the scene.
// Where more than 64 and a 64th of the scene would be, the bounds are raised until it is not.
void splitBySize(const WorkingSet& set, SizeSplit& split);

}  // namespace deformable_contact_monitor
