// Reads mesh files. Nothing is changed on the way, so the index of a triangle is its place in the
// file.
#pragma once

#include <string>

#include "core/export.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Reads an OBJ, PLY (ascii, both endians, float or double), STL (ascii, binary) or OFF file. The
// file name's ending tells the format, and the content tells binary STL from ascii. Polygons become
// fans of triangles around their first vertex. Vertices are not welded, removed or scaled. A
// coordinate becomes the nearest float32 of its text or double; beyond float32's range that is
// infinity. Non-finite coordinates are kept. Throws std::runtime_error, "<path>: <what>" or
// "<path>:<line>: <what>", if the file cannot be read, is malformed or has no triangle.
DCM_EXPORT TriangleMesh readMeshFile(const std::string& path);

// Returns whether the name ends like one of these formats.
DCM_EXPORT bool isMeshFileName(const std::string& path);

}  // namespace deformable_contact_monitor
