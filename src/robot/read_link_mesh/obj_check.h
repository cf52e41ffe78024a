// What Assimp takes on trust in an OBJ file.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// Assimp cuts off vertex numbers of faces that do not fit 32 bits. Throws std::runtime_error, "line
// N: <what>", at one. The others it refuses itself if there is no such vertex.
void checkObj(const std::string& text);

}  // namespace deformable_contact_monitor
