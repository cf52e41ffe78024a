// Finds the groups of a PLY file, which are named PROPERTY=VALUE: faces with that value of a
// property, or triangles whose three vertices have it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/host_list.h"
#include "core/mesh_files/mesh_groups.h"
#include "core/mesh_files/ply_header.h"

namespace deformable_contact_monitor {

// Collects the values of those properties of which groups are wanted. A reader stores the values of
// each record where valueOf() says, and ends the record.
class PlyAttributes {
 public:
  // `groups` may be null, if nobody asked for groups. The header and the groups must outlive this.
  PlyAttributes(const PlyHeader& header, MeshGroups* groups);

  // Returns where the reader shall store the value of one of the header's properties in this
  // record; null if nobody wants it.
  float* valueOf(const PlyProperty& property);
  // Ends a record, which made the triangles [first, end).
  void endRecord(PlyElementKind kind, std::size_t first, std::size_t end);

  // Adds the triangles of groups of vertices. All vertices and triangles have been read.
  void addByVertices(const HostList<std::uint32_t>& triangles);

 private:
  // One property, and the groups of its values.
  struct Attribute {
    const PlyProperty* property;
    PlyElementKind kind;  // faces or vertices
    std::map<std::int32_t, MeshGroups::Group*> by_value;
    float value = 0;                 // in this record
    std::vector<float> of_vertices;  // if it is one of vertices
  };

  void addWanted(const PlyHeader& header, const std::string& name, MeshGroups* groups);
  static MeshGroups::Group* groupOf(const Attribute& attribute, float value);

  std::vector<Attribute> attributes_;
};

}  // namespace deformable_contact_monitor
