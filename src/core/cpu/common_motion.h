// How the vertices of a scene move in a step, for the most part.
#pragma once

#include "core/scene.h"

namespace deformable_contact_monitor {

// commonMotion() of some vertices, evenly spread, of all bodies that take part [m].
DCM_EXPORT Vec3f commonMotionOf(const Scene& scene);

}  // namespace deformable_contact_monitor
