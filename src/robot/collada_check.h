// What Assimp takes on trust in a COLLADA file.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// Assimp 5.2 reads beyond an array that is shorter than its accessor says, and never ends at a
// letter in a list of indices. Throws std::runtime_error, "line N: <what>", at either, and if the
// file is not well-formed XML or cannot be read.
void checkCollada(const std::string& path);

}  // namespace deformable_contact_monitor
