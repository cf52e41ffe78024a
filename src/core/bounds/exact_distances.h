// Bounds of distances from what an exact detector found.
#pragma once

#include <utility>
#include <vector>

#include "core/detector.h"
#include "core/export.h"
#include "core/options.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Returns the distance of each of these pairs that is of two different bodies, ascending. Its lower
// bound is 0 unless the exact detector listed all contacts or, if nearest pairs are wanted,
// searched all of them. Then it follows from the nearest contact, or is the margin if there is
// none.
DCM_EXPORT std::vector<BodyDistance> distancesOf(
    const Scene& scene, const std::vector<std::pair<BodyId, BodyId>>& pairs,
    const DetectionResult& exact, bool wants_nearest, bool is_searched);

// Returns whether an exact detector that can search nearest pairs does so: because the user wants
// them, or because a tolerance asks for distances of bodies.
inline bool searchesNearest(const Options& options) {
  return options.nearest || (options.tolerance_m > 0 && options.motion == Motion::kInstant);
}

// Completes the result of such a detector after its search. Fills in `distances` if there is a
// tolerance, or if the cycle was cut off, so that contacts may be missing; not in swept motion,
// where contacts and nearest pairs are of different times. Removes nearest pairs that were searched
// for a tolerance alone. `is_searched` says whether the search was complete.
DCM_EXPORT void giveDistances(const Scene& scene, const Options& options, bool is_searched,
                              DetectionResult* result);

}  // namespace deformable_contact_monitor
