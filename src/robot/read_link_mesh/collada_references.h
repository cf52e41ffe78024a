// Nodes and skins of a COLLADA file that refer to others.
#pragma once

#include <tinyxml2.h>

namespace deformable_contact_monitor {

// Assimp follows nodes that instance themselves, however indirectly, until its stack is full, and
// skins that deform themselves for ever; ten nodes that instance the next one ten times fill any
// memory. Throws std::runtime_error, "line N: <what>", at each.
void checkColladaReferences(const tinyxml2::XMLDocument& document);

}  // namespace deformable_contact_monitor
