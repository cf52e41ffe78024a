// Bounds of distances from what an exact detector found.
#pragma once

#include <utility>
#include <vector>

#include "core/detector.h"
#include "core/export.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Returns the distance of each of these pairs that is of two different bodies, ascending. Its lower
// bound is 0 unless the exact detector listed all contacts or, if nearest pairs are wanted,
// searched all of them. Then it follows from the nearest contact, or is the margin if there is
// none.
DCM_EXPORT std::vector<BodyDistance> distancesOf(
    const Scene& scene, const std::vector<std::pair<BodyId, BodyId>>& pairs,
    const DetectionResult& exact, bool wants_nearest, bool is_searched);

}  // namespace deformable_contact_monitor
