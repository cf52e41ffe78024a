// Readers of the mesh formats. readMeshFile() (core/mesh_file.h) calls them, and its contract holds
// for them too. Each reader gets the whole file as one string and keeps vertices and faces in file
// order. It compares announced counts with the file's size before it allocates memory for them, so
// that a damaged file cannot exhaust the memory.
#pragma once

#include <string>
#include <string_view>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Return the mesh in `content`, the whole file. `path` is for error messages only. Vertex indices
// of the mesh are in range. It may have no triangle; the caller rejects it then. Errors are
// std::runtime_error that begin with the path and name the line or byte.
TriangleMesh readObj(const std::string& path, std::string_view content);
// Reads ascii OFF files, with or without texture coordinates, colours and normals.
TriangleMesh readOff(const std::string& path, std::string_view content);
// Reads ascii and binary PLY files of either byte order.
TriangleMesh readPly(const std::string& path, std::string_view content);
// Reads ascii and binary STL files. The vertices of facets are not merged, even if they are equal.
TriangleMesh readStl(const std::string& path, std::string_view content);

// Turns a polygon into a fan of triangles around its first vertex. Vertices are added one by one.
class PolygonFan {
 public:
  // The indices are appended to `triangles`, three for each triangle. The list must outlive the
  // fan.
  explicit PolygonFan(HostList<std::uint32_t>* triangles) : triangles_(triangles) {}

  // Adds the next corner of the polygon. From the third corner on, each adds one triangle, so the
  // order of the corners, and with it the outside, is kept. The result is right for convex
  // polygons.
  void add(std::uint32_t vertex) {
    if (size_ == 0) first_ = vertex;
    if (size_ >= 2) triangles_->insert(triangles_->end(), {first_, previous_, vertex});
    previous_ = vertex;
    ++size_;
  }
  std::size_t size() const { return size_; }

 private:
  HostList<std::uint32_t>* triangles_;
  std::uint32_t first_ = 0, previous_ = 0;
  std::size_t size_ = 0;
};

}  // namespace deformable_contact_monitor
