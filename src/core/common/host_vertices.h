// The refusal of backends that cannot read device memory.
#pragma once

#include <string>

#include "core/scene.h"

namespace deformable_contact_monitor {

// Throws std::invalid_argument, naming the body, if the vertices of one that takes part are on a
// device.
void requireHostVertices(const Scene& scene, const std::string& backend);

}  // namespace deformable_contact_monitor
