// Turns the polygons of a mesh file into triangles. All formats with polygons use it: OBJ, OFF,
// PLY.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh_file.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Collects polygons corner by corner, as fans of triangles around the first corner, and corrects
// the fans when all vertices are known, since a file may list its faces first.
//
// A polygon of n corners always makes n - 2 triangles, in its place among the others and with its
// sense of rotation, so the outside is kept. Some of them may have no area.
class PolygonList {
 public:
  // The vertex indices are appended to `triangles`, three for each triangle. The list must outlive
  // this.
  explicit PolygonList(HostList<std::uint32_t>* triangles) : triangles_(triangles) {}

  // Begins the next polygon.
  void begin();

  // Adds the next corner of the polygon. From the third one on, each adds one triangle.
  void add(std::uint32_t vertex) {
    if (size_ == 0) first_vertex_ = vertex;
    if (size_ >= 2) triangles_->insert(triangles_->end(), {first_vertex_, last_vertex_, vertex});
    last_vertex_ = vertex;
    ++size_;
  }

  // Returns the number of the polygon's corners so far.
  std::size_t size() const { return size_; }

  // Replaces the fan of each planar polygon that is not convex by triangles whose union is the
  // polygon, whatever corner it begins with. Bridges to holes, equal corners and corners on one
  // line are allowed. All indices must be in range. Adds a note to `report` if polygons stay fans
  // although they are not planar, cross themselves or have a corner that is not finite: their
  // triangles are not certainly the surface that was meant. Keeps the fans in `report` if it
  // replaces any.
  void triangulate(const HostList<float>& vertices, MeshFileReport* report);

 private:
  // A polygon of more than three corners.
  struct Polygon {
    std::size_t first;  // its first index in the list of triangles
    std::size_t size;   // number of corners
  };

  HostList<std::uint32_t>* triangles_;
  std::vector<Polygon> polygons_;  // without the one that is being added
  std::size_t begin_ = 0;          // where the polygon that is being added begins
  std::size_t size_ = 0;
  std::uint32_t first_vertex_ = 0, last_vertex_ = 0;
};

}  // namespace deformable_contact_monitor
