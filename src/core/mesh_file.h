// Reads mesh files.
#pragma once

#include <string>
#include <vector>

#include "core/export.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Holds what readMeshFile() reports beside the mesh.
struct MeshFileReport {
  // One line, without the path, for each thing that may not be meant as it was read: how many
  // polygons are not planar or cross themselves, and bytes that were ignored.
  std::vector<std::string> notes;
  // The triangles as they would be with each polygon as a fan around its first corner. They are
  // equal for two files with the same faces, while the triangles of a polygon depend on where its
  // corners are.
  HostList<std::uint32_t> fans;
};

// Reads an OBJ, PLY (ascii, both endians, float or double), STL (ascii, binary) or OFF file. The
// file name's ending tells the format, and the content tells binary STL from ascii. Vertices are
// not welded, removed or scaled. A coordinate becomes the nearest float32 of its text or double;
// beyond float32's range that is infinity. Non-finite coordinates are kept.
//
// Triangles are numbered in file order. A polygon of n corners makes n - 2 of them: a fan around
// its first corner if it is convex. If it is planar and not convex, they cover exactly the polygon,
// and are the same whatever corner it begins with. Others are fans, too. A PLY triangle strip makes
// the triangles of its vertices in order, without those that use a vertex twice.
//
// Throws std::runtime_error, "<path>: <what>" or "<path>:<line>: <what>", if the file cannot be
// read, is malformed or has no triangle. It says so if the content looks like that of another kind
// of file: a Git LFS pointer, an HTML page, an archive, UTF-16 text. `report`, if it is given, is
// replaced.
DCM_EXPORT TriangleMesh readMeshFile(const std::string& path, MeshFileReport* report = nullptr);

// Returns whether the name ends like one of these formats.
DCM_EXPORT bool isMeshFileName(const std::string& path);

}  // namespace deformable_contact_monitor
