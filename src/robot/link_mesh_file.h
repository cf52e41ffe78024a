// Mesh files of robot links, by Assimp.
#pragma once

#include <string>

#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

// Reads STL (ascii or binary), DAE or OBJ; the format is the file name's ending, STL's flavour its
// content. Node hierarchies are applied, nodes in depth-first order; polygons are triangulated;
// points and lines are dropped; nothing is joined or removed.
// As in rviz, COLLADA's <unit> is applied and its <up_axis> is not: a link's frame is what the
// file's numbers say.
// Throws std::runtime_error, "<path>: <what>", if the file cannot be read or holds no triangle.
SourceMesh readLinkMeshFile(const std::string& path);

}  // namespace deformable_contact_monitor
