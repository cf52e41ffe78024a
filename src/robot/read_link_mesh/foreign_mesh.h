// Reads mesh files of robot links.
#pragma once

#include <string>

#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

// Returns what readLinkMeshFile() (robot/link_mesh_files.h) returns, but reads the file in this
// process: a file may crash or block it, or take much memory. Throws an exception whose text says
// why, without the file's name, and std::bad_alloc if the memory is not enough.
SourceMesh readForeignMesh(const std::string& path);

}  // namespace deformable_contact_monitor
