// Readers of the mesh formats. readMeshFile() (core/mesh_file.h) calls them, and its contract holds
// for them too. Each reader gets the whole file as one string and keeps vertices and faces in file
// order. It compares announced counts with the file's size before it allocates memory for them, so
// that a damaged file cannot exhaust the memory.
#pragma once

#include <string>
#include <string_view>

#include "core/mesh_file.h"
#include "core/mesh_files/mesh_groups.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Return the mesh in `content`, the whole file. `path` is for error messages only. Vertex indices
// of the mesh are in range. It may have no triangle; the caller rejects it then. `report` gets
// notes, and fans if there are other triangles in their place. `groups`, if they are given, get
// their triangles; formats without groups ignore them. Errors are std::runtime_error that begin
// with the path and name the line or byte.
TriangleMesh readObj(const std::string& path, std::string_view content, MeshFileReport* report,
                     MeshGroups* groups);
// Reads ascii OFF files, with or without texture coordinates, colours and normals.
TriangleMesh readOff(const std::string& path, std::string_view content, MeshFileReport* report,
                     MeshGroups* groups);
// Reads ascii and binary PLY files of either byte order.
TriangleMesh readPly(const std::string& path, std::string_view content, MeshFileReport* report,
                     MeshGroups* groups);
// Reads ascii and binary STL files. The vertices of facets are not merged, even if they are equal.
TriangleMesh readStl(const std::string& path, std::string_view content, MeshFileReport* report,
                     MeshGroups* groups);

// Reads a file with the reader for its name's ending, and rejects what readMeshFile() rejects. If
// the file cannot be read, and its content shows why, as for an HTML page, the error says that.
TriangleMesh readMeshContent(const std::string& path, std::string_view content,
                             MeshFileReport* report, MeshGroups* groups = nullptr);

// Returns what the content of a file that no reader can read looks like, to be put after its name:
// "is a Git LFS pointer ...". Returns an empty text if it looks like nothing known.
std::string unreadableBecause(std::string_view content);

}  // namespace deformable_contact_monitor
