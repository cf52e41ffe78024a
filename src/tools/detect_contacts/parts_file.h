// Reads the file of --parts: which triangles of a body are which part, and which pairs of parts are
// left out.
#pragma once

#include <string>

#include "core/scene.h"

namespace deformable_contact_monitor {

// Sets the parts of a scene's bodies, and disables pairs of parts, as the file says; README.md
// describes its lines. Throws std::runtime_error, naming the file and the line.
void readParts(const std::string& path, Scene* scene);

}  // namespace deformable_contact_monitor
