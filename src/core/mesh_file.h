// Reads mesh files.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
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

// Triangle numbers, from the first to the last one of each range. Ranges are ascending and
// disjoint.
using TriangleRanges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// Reads a mesh file as readMeshFile() does, and finds the triangles of groups with these names:
// `triangles` is replaced by the ranges of each of them.
//
// In an OBJ file, a group has the faces that come after a line `g NAME` or `o NAME`, up to the next
// line of that kind. In a PLY file, a group is named PROPERTY=VALUE, with a whole number below
// 2^24: it has the faces with that value of the property. If the faces have no such property, it
// has the triangles of which all three vertices have that value.
//
// Throws what readMeshFile() throws, and std::runtime_error, "<path>: <what>", if the file does not
// have such a group, or if the group has no triangle.
DCM_EXPORT TriangleMesh readMeshGroups(const std::string& path,
                                       const std::vector<std::string>& names,
                                       std::vector<TriangleRanges>* triangles);

// Returns whether the name ends like one of these formats.
DCM_EXPORT bool isMeshFileName(const std::string& path);

}  // namespace deformable_contact_monitor
