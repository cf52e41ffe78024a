// One reader per mesh format, behind readMeshFile (core/mesh_file.h), whose contract they keep.
#pragma once

#include <string>
#include <string_view>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// `content` is the whole file; `path` is for messages only. A mesh without a triangle may be
// returned: the caller refuses it. Vertex indices are in range.
TriangleMesh readObj(const std::string& path, std::string_view content);
TriangleMesh readOff(const std::string& path, std::string_view content);
TriangleMesh readPly(const std::string& path, std::string_view content);
TriangleMesh readStl(const std::string& path, std::string_view content);

// Turns a polygon's vertices, given one by one, into a fan of triangles about the first.
class PolygonFan {
 public:
  explicit PolygonFan(HostList<std::uint32_t>* triangles) : triangles_(triangles) {}

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
