// Witness points, normals and depths of a result's contacts, computed on the host.
#pragma once

#include "core/detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Fills result.geometry, for all of result.contacts, on threads. Does nothing unless
// options.geometry is set. Leaves it empty if options.limits end the work before it is complete.
// The scene's vertices must be on the host.
void writeGeometry(const Scene& scene, const Options& options, DetectionResult& result);

}  // namespace deformable_contact_monitor
