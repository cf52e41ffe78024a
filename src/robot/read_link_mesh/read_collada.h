// Reads COLLADA files of robot links with Assimp.
#pragma once

#include <string>

#include "core/mesh_file.h"
#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

// Returns the mesh of a COLLADA text, as readLinkMeshFile() (robot/link_mesh_files.h) says. The
// text may crash or block this process, or take much memory. Throws an exception whose text says
// why, without a file's name, and std::bad_alloc if the memory is not enough. `report` gets notes
// of polygons, as with the other formats.
SourceMesh readCollada(const std::string& text, MeshFileReport* report);

}  // namespace deformable_contact_monitor
