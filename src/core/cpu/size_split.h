// Separates the few oversized triangles of the working set from the regular ones, and finds the
// scale that brings the regular ones into [-1, 1].
//
// Clustering works in these scaled coordinates. One huge or far triangle would spoil them, so that
// such triangles go to a list of their own (stage `oversized`).
#pragma once

#include <cstddef>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/index.h"
#include "core/cpu/transform.h"
#include "core/export.h"
#include "core/rules/scene_scale.h"

namespace deformable_contact_monitor {

// The two lists of triangles, the rule that made them, and the scale of the regular ones.
struct SizeSplit {
  std::size_t spare = 64;                // as many may be oversized in any scene; set by the caller
  std::vector<TriangleIndex> oversized;  // of the working set, ascending
  std::vector<TriangleIndex> regular;    // all others, ascending
  SizeRule rule;                         // the rule that separated them
  SceneScale scale;                      // brings the regular triangles into [-1, 1]
  SceneScale scale_after;  // for the end of the time interval, without the common motion

  void scaled(const Triangle& t, Vec3f points[3]) const { apply(scale, t, points); }
  // Scales a moving triangle's points; those of the earlier state come first.
  void scaled(const MovingTriangle& t, Vec3f points[6]) const {
    apply(scale, t.from, points);
    apply(scale_after, t.to, points + 3);
  }

 private:
  static void apply(const SceneScale& scale, const Triangle& t, Vec3f points[3]) {
    for (int k = 0; k < 3; ++k) points[k] = scale.apply(t.v[k]);
  }
};

// Fills in `split`. A triangle is oversized if its extent is more than 32 times the median extent,
// or its distance from the middle of the scene more than 64 times the median distance. If that
// holds for more than `spare` triangles and a 64th of the scene, the bounds are raised until it
// does not. Once the limit is over, the content of `split` is unspecified.
DCM_EXPORT void splitBySize(const WorkingSet& set, SizeSplit& split,
                            const CycleLimit& limit = noLimit());

}  // namespace deformable_contact_monitor
