// Checks a COLLADA text before Assimp reads it. Assimp 5.2 takes some numbers of a file on trust
// and would return a wrong mesh without an error. What only makes Assimp crash, hang or fill its
// memory is not checked here: the reader is a process of its own for that.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// Throws std::runtime_error, "line N: <what>", if the text is not well-formed XML, if an index or
// count is negative, no integer or beyond 31 bits (Assimp would change it), or if an accessor needs
// more numbers than its array has (Assimp would read beyond the array).
void checkCollada(const std::string& text);

}  // namespace deformable_contact_monitor
