// First times that hold for the true motion of bodies that rotate, not only for straight lines.
#pragma once

#include "core/detector.h"
#include "core/options.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Moves the lower bound of the first time of each contact back to where the two triangles may come
// within their pads of each other. Before that time no motion within the pads makes them touch. The
// upper bounds stay. `result` is that of a detection of the scene with swept motion and first
// times. Contacts of a body with itself, and of bodies without pads, stay as they are. Where
// options.limits leave no time, and for vertices on a device, the lower bound becomes 0.
void includePads(const Scene& scene, const Options& options, DetectionResult* result);

}  // namespace deformable_contact_monitor
