// The parameter `parts` of an object: how the user chooses the triangles of its named parts.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh_file.h"
#include "monitor/rules/parameter_reader.h"

namespace deformable_contact_monitor {

// The largest margin of a body or a part [m].
constexpr double kMaxMarginM = 10;

// A closed box with edges along the axes [m].
struct PartBox {
  std::array<double, 3> min{}, max{};
};

// One named part of an object. Its triangles are given by ranges or by a box.
struct PartParameters {
  std::string name;
  TriangleRanges ranges;
  // The triangles whose centroid lies in it, in the object's first mesh and in that mesh's frame.
  std::optional<PartBox> box{};
  // The mesh that the ranges are taken from, if they are a group of a mesh file; else null.
  std::shared_ptr<const TriangleMesh> mesh{};
  // The part's own margin [m]; nothing: that of its object.
  std::optional<float> margin_m{};
};

// Reads the key `parts` of an object. `faces` is the object's mesh file, or empty; parts may be
// groups of it. Adds a problem for each part that cannot be used: by its name, by what it is made
// of, and for triangles that two parts have. Adds unknown keys to `warnings`.
std::vector<PartParameters> readParts(ParameterReader* object, const std::string& object_name,
                                      const std::string& faces, std::vector<std::string>* warnings);

}  // namespace deformable_contact_monitor
