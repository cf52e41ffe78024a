#include "core/mesh_files/ply_attributes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace deformable_contact_monitor {
namespace {

constexpr std::int32_t kValueLimit = 1 << 24;  // whole numbers below it are exact in float32

// Returns whether groups may be made of a property of an element of that kind.
bool makesGroups(const PlyProperty& property, PlyElementKind kind) {
  return (kind == PlyElementKind::kFace || kind == PlyElementKind::kVertex) && !property.is_list &&
         property.role == PlyRole::kIgnored;
}

// Returns the property of that name in the element of that kind; null if there is none.
const PlyProperty* propertyOf(const PlyHeader& header, PlyElementKind kind,
                              const std::string& name) {
  for (const PlyElement& element : header.elements) {
    if (element.kind != kind) continue;
    for (const PlyProperty& property : element.properties) {
      if (property.name == name && makesGroups(property, kind)) return &property;
    }
  }
  return nullptr;
}

}  // namespace

PlyAttributes::PlyAttributes(const PlyHeader& header, MeshGroups* groups) {
  if (groups == nullptr) return;
  for (const PlyElement& element : header.elements) {
    for (const PlyProperty& property : element.properties) {
      if (makesGroups(property, element.kind)) groups->note(property.name + "=VALUE");
    }
  }
  for (const auto& wanted : groups->wanted()) addWanted(header, wanted.first, groups);
}

// Adds a group that is named PROPERTY=VALUE, if the header has such a property.
void PlyAttributes::addWanted(const PlyHeader& header, const std::string& name,
                              MeshGroups* groups) {
  const std::size_t equals = name.rfind('=');
  if (equals == std::string::npos) return;
  std::int32_t value = 0;
  const char* const end = name.data() + name.size();
  const auto parsed = std::from_chars(name.data() + equals + 1, end, value);
  if (parsed.ec != std::errc() || parsed.ptr != end || value <= -kValueLimit ||
      value >= kValueLimit) {
    return;
  }
  for (const PlyElementKind kind : {PlyElementKind::kFace, PlyElementKind::kVertex}) {
    const PlyProperty* const property = propertyOf(header, kind, name.substr(0, equals));
    if (property == nullptr) continue;
    auto attribute =
        std::find_if(attributes_.begin(), attributes_.end(),
                     [property](const Attribute& o) { return o.property == property; });
    if (attribute == attributes_.end()) {
      attribute = attributes_.insert(attribute, Attribute{property, kind, {}, 0, {}});
    }
    attribute->by_value[value] = groups->find(name);
    return;
  }
}

float* PlyAttributes::valueOf(const PlyProperty& property) {
  for (Attribute& attribute : attributes_) {
    if (attribute.property == &property) return &attribute.value;
  }
  return nullptr;
}

void PlyAttributes::endRecord(PlyElementKind kind, std::size_t first, std::size_t end) {
  for (Attribute& attribute : attributes_) {
    if (attribute.kind != kind) continue;
    if (kind == PlyElementKind::kVertex) {
      attribute.of_vertices.push_back(attribute.value);
    } else if (MeshGroups::Group* const group = groupOf(attribute, attribute.value)) {
      group->add(first, end);
    }
  }
}

void PlyAttributes::addByVertices(const HostList<std::uint32_t>& triangles) {
  for (const Attribute& attribute : attributes_) {
    if (attribute.kind != PlyElementKind::kVertex) continue;
    for (std::size_t t = 0; t < triangles.size() / 3; ++t) {
      const std::uint32_t* const corner = &triangles[3 * t];
      const float value = attribute.of_vertices[corner[0]];
      if (attribute.of_vertices[corner[1]] != value || attribute.of_vertices[corner[2]] != value) {
        continue;
      }
      if (MeshGroups::Group* const group = groupOf(attribute, value)) group->add(t, t + 1);
    }
  }
}

MeshGroups::Group* PlyAttributes::groupOf(const Attribute& attribute, float value) {
  if (!(std::abs(value) < static_cast<float>(kValueLimit)) || value != std::floor(value)) {
    return nullptr;
  }
  const auto found = attribute.by_value.find(static_cast<std::int32_t>(value));
  return found == attribute.by_value.end() ? nullptr : found->second;
}

}  // namespace deformable_contact_monitor
