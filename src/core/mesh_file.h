// Mesh files to meshes, bit by bit: triangle ids are file order.
#pragma once

#include <string>

#include "core/export.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Reads OBJ, PLY (ascii, both endians, float or double), STL (ascii, binary) or OFF; the format is
// the file name's ending, STL's flavour its content. Polygons are fanned from their first vertex;
// nothing is welded, removed or scaled. A coordinate is the nearest float32 of its text or double
// (beyond float32's range: infinity), and non-finite ones are kept.
// Throws std::runtime_error, "<path>: <what>" or "<path>:<line>: <what>", if the file cannot be
// read, is malformed or holds no triangle.
DCM_EXPORT TriangleMesh readMeshFile(const std::string& path);

// Whether the name ends like one of these formats.
DCM_EXPORT bool isMeshFileName(const std::string& path);

}  // namespace deformable_contact_monitor
