// What Assimp takes on trust in a COLLADA file.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// Assimp 5.2 reads beyond an array that is shorter than its accessor says, never ends at a letter
// in a list of indices, changes indices that are negative or do not fit 32 bits, and does what
// checkColladaReferences says. Throws std::runtime_error, "line N: <what>", at each of those, and
// if the text is not well-formed XML.
void checkCollada(const std::string& text);

}  // namespace deformable_contact_monitor
