// Objects of type `rigid`: triangles of a file or a primitive that a TF frame poses, such as a
// table or a tool.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"
#include "monitor/rules/parameter_reader.h"

namespace deformable_contact_monitor {

// One entry of the parameter `objects` with type `rigid`.
struct RigidParameters {
  std::string name;
  std::string frame;                           // of the triangles, in TF
  std::shared_ptr<const TriangleMesh> mesh{};  // [m], in that frame; null if it could not be read
  float margin_m = 0;                          // its own margin, or the general one
  bool shares_margin = false;                  // has no margin of its own
  float radius_m = 0;  // the object is all points at most this far from its triangles
};

// Reads frame and shape. The caller reads the name, the margin and the radius. A mesh file is read
// at once, as link meshes are, in a process of its own and within its limits. Adds a problem for
// each value that cannot be used, and for each key that only other types have; adds unknown keys of
// maps to `warnings`.
void readRigid(ParameterReader* entry, std::vector<std::string>* warnings, RigidParameters* rigid);

}  // namespace deformable_contact_monitor
