// The geometry of a result's contacts, on the host.
#pragma once

#include "core/detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Fills result.geometry, if options.geometry, on threads. Where options.limits end it, it is left
// empty. The scene's vertices must be on the host.
void writeGeometry(const Scene& scene, const Options& options, DetectionResult& result);

}  // namespace deformable_contact_monitor
