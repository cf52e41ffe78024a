// The working set's very large triangles, and the scale of all the others.
#pragma once

#include <cstddef>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/index.h"
#include "core/cpu/transform.h"
#include "core/export.h"
#include "core/rules/scene_scale.h"
#include "core/rules/size_rule.h"

namespace deformable_contact_monitor {

struct SizeSplit {
  std::size_t spare = 64;            // as many may be large whatever the scene's size; the caller's
  std::vector<TriangleIndex> large;  // of the working set, ascending
  std::vector<TriangleIndex> regular;  // all others, ascending
  SizeRule rule;                       // that told them apart
  SceneScale scale;                    // brings the regular triangles into [-1, 1]
  SceneScale scale_after;  // of what moves: for the step's end, without the common motion

  void scaled(const Triangle& t, Vec3f points[3]) const { apply(scale, t, points); }
  // Where it was comes first.
  void scaled(const MovingTriangle& t, Vec3f points[6]) const {
    apply(scale, t.from, points);
    apply(scale_after, t.to, points + 3);
  }

 private:
  static void apply(const SceneScale& scale, const Triangle& t, Vec3f points[3]) {
    for (int k = 0; k < 3; ++k) points[k] = scale.apply(t.v[k]);
  }
};

// Large: 32 times the median extent, or 64 times the median distance from the middle of the scene.
// Where more than `spare` and a 64th of the scene would be, the bounds are raised until it is not.
// Where the limit was over, the split is of no use.
DCM_EXPORT void splitBySize(const WorkingSet& set, SizeSplit& split,
                            const CycleLimit& limit = noLimit());

}  // namespace deformable_contact_monitor
