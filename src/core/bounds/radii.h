// Bodies with a radius, and parts with margins of their own. Detectors know triangles and margins
// of bodies only: near pairs become contacts, or are dropped.
#pragma once

#include <memory>

#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

// Returns a detector that does what `detector` does, and knows Body::radius_m. Two triangles of
// bodies a and b are then a contact iff their distance, rounded to float32 (see
// DetectionResult::separations_m), is at most R = radius_a + radius_b, added in double and rounded
// down to float32. All distances of the result are those of the triangles minus radius_a +
// radius_b, rounded to float32, or 0 if they touch; the error is that of the triangles' distance,
// at most 2^-24 of it. In particular
// - the nearest pair of two bodies are the triangles that are nearest to each other without their
//   radii, so of bodies that touch it is the deepest one. Its points lie on the surfaces of the
//   bodies; of bodies that touch, both are the middle of the overlap on the line between the
//   closest points of the two triangles.
// - the geometry of a contact has the points of those surfaces too, and its separation is the
//   triangles' one minus radius_a + radius_b. Where the triangles themselves intersect, the points
//   stay in their intersection.
// - of a body with itself, pairs of triangles count only if the shortest way from one to the other
//   along the edges of its mesh is at least pi times its radius. That is as far as a rope of that
//   thickness takes to come back beside itself. Vertices at the same place are one.
//
// It also knows margins of parts (Scene::setPartMargins): what the largest margins of the bodies
// list or find is dropped if it is beyond the margin of its own two parts.
//
// Scenes without either are handed on as they are. With radii the scene is copied in each cycle,
// and a search (options.nearest without near_pairs) with margins is made beside the list of
// contacts. detect() also throws std::invalid_argument, naming a body with a radius, for
// Motion::kSwept, for options.tolerance_m > 0, and for a body on a device whose pair with itself is
// enabled.
DCM_EXPORT std::unique_ptr<Detector> withRadiiAndPartMargins(std::unique_ptr<Detector> detector);

}  // namespace deformable_contact_monitor
