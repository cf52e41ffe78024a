// Mesh files of robot links, by Assimp.
#pragma once

#include <string>

#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

// What readLinkMeshFile (robot/link_mesh_file.h) gives, read in this process: a file may crash it,
// or keep it for ever. Throws std::runtime_error, without the file's name.
SourceMesh readWithAssimp(const std::string& path);

}  // namespace deformable_contact_monitor
