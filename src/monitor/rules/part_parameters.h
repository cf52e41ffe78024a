// The parameter `parts` of an object: how the user chooses the triangles of its named parts.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "monitor/rules/parameter_reader.h"

namespace deformable_contact_monitor {

// A closed box with edges along the axes [m].
struct PartBox {
  std::array<double, 3> min{}, max{};
};

// One named part of an object. Its triangles are given by ranges or by a box.
struct PartParameters {
  std::string name;
  // Triangle indices, from the first to the last one of each range, ascending and disjoint.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges;
  // The triangles whose centroid lies in it, in the object's first mesh and in that mesh's frame.
  std::optional<PartBox> box{};
};

// Reads the key `parts` of an object. Adds a problem for each part that cannot be used: by its
// name, by what it is made of, and for triangles that two parts have. Adds unknown keys to
// `warnings`.
std::vector<PartParameters> readParts(ParameterReader* object, const std::string& object_name,
                                      std::vector<std::string>* warnings);

}  // namespace deformable_contact_monitor
