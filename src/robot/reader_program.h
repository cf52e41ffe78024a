// Where the program read_link_mesh is.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// Its path: beside the program or shared library that this code is part of, in the package's
// folder of programs next to that library, or in a workspace of CMAKE_PREFIX_PATH. So it is the
// same build's in the devel space, in an install space and in a plain build folder, also for a
// nodelet in somebody else's process. Throws std::runtime_error with where it was looked for.
std::string findReaderProgram();

}  // namespace deformable_contact_monitor
