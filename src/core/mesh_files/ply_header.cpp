// Reads a PLY header and finds in it what a mesh needs. Every line begins with a keyword. Comments
// are skipped, but an unknown keyword is an error, because the records might not be laid out as
// expected then. Everything about the properties is checked here, so the reader of the records can
// rely on it.
#include "core/mesh_files/ply_header.h"

#include <algorithm>
#include <utility>

#include "core/mesh_files/mesh_text.h"

namespace deformable_contact_monitor {
namespace {

PlyType readType(MeshText& text) {
  constexpr std::pair<std::string_view, PlyType> kNames[] = {
      {"char", PlyType::kInt8},     {"int8", PlyType::kInt8},     {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},   {"short", PlyType::kInt16},   {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16}, {"uint16", PlyType::kUint16}, {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},   {"uint", PlyType::kUint32},   {"uint32", PlyType::kUint32},
      {"float", PlyType::kFloat},   {"float32", PlyType::kFloat}, {"double", PlyType::kDouble},
      {"float64", PlyType::kDouble}};
  const std::string_view word = text.word();
  const auto* found = std::find_if(std::begin(kNames), std::end(kNames),
                                   [word](const auto& entry) { return entry.first == word; });
  if (found == std::end(kNames)) text.failAt(word, "a property type");
  return found->second;
}

// Reads the encoding. The version number after it is ignored.
PlyFormat readFormat(MeshText& text) {
  const std::string_view word = text.word();
  if (word == "ascii") return PlyFormat::kAscii;
  if (word == "binary_little_endian") return PlyFormat::kLittleEndian;
  if (word == "binary_big_endian") return PlyFormat::kBigEndian;
  text.failAt(word, "ascii, binary_little_endian or binary_big_endian");
}

// Reads the rest of a line such as "element vertex 8". The element's name is kept in quotes, as
// messages show it.
PlyElement readElement(MeshText& text) {
  PlyElement element;
  element.name = quoted(text.word());
  if (element.name == "'vertex'") element.kind = PlyElementKind::kVertex;
  if (element.name == "'face'") element.kind = PlyElementKind::kFace;
  if (element.name == "'tristrips'") element.kind = PlyElementKind::kStrips;
  element.count = text.count("the number of elements", UINT64_MAX);
  return element;
}

// Returns what a property means for a mesh. Writers use both names of the list of indices.
PlyRole roleOf(std::string_view name, PlyElementKind kind) {
  if (kind == PlyElementKind::kVertex) {
    if (name == "x") return PlyRole::kX;
    if (name == "y") return PlyRole::kY;
    if (name == "z") return PlyRole::kZ;
  } else if (kind != PlyElementKind::kOther &&
             (name == "vertex_indices" || name == "vertex_index")) {
    return PlyRole::kVertexIndices;
  }
  return PlyRole::kIgnored;
}

// Reads the rest of a line such as "property float x" or "property list uchar int vertex_indices".
// A copy of the cursor looks ahead at the first word, which is "list" or a type.
PlyProperty readProperty(MeshText& text, PlyElementKind kind) {
  PlyProperty property;
  MeshText ahead = text;
  property.is_list = ahead.word() == "list";
  if (property.is_list) {
    text.word();
    property.count_type = readType(text);
  }
  property.type = readType(text);
  const std::string_view name = text.word();
  if (name.empty()) text.failAt(name, "the property's name");
  property.name = name;
  property.role = roleOf(name, kind);
  if (property.role != PlyRole::kIgnored &&
      property.is_list != (property.role == PlyRole::kVertexIndices)) {
    text.fail("property " + quoted(name) + (property.is_list ? " is a list" : " is no list"));
  }
  return property;
}

bool hasRole(const PlyElement& element, PlyRole role) {
  return std::any_of(element.properties.begin(), element.properties.end(),
                     [role](const PlyProperty& property) { return property.role == role; });
}

// Throws if an element lacks what a mesh needs. Elements without properties are rejected if they
// have records, because these would take no bytes and any count would fit the file.
void requireRoles(const MeshText& text, const PlyElement& element) {
  if (element.count > 0 && element.properties.empty()) {
    text.fail("element " + element.name + " has no properties");
  }
  if (element.kind == PlyElementKind::kOther) return;
  const bool is_vertex = element.kind == PlyElementKind::kVertex;
  const bool complete = is_vertex
                            ? hasRole(element, PlyRole::kX) && hasRole(element, PlyRole::kY) &&
                                  hasRole(element, PlyRole::kZ)
                            : hasRole(element, PlyRole::kVertexIndices);
  if (!complete) {
    text.fail("element " + element.name +
              (is_vertex ? " has no properties x, y and z" : " has no list vertex_indices"));
  }
}

// Appends an element. There may be only one list of vertices to which indices refer, one of faces,
// and one of strips.
void addElement(const MeshText& text, PlyElement element, PlyHeader* header) {
  const auto same_kind = [&element](const PlyElement& o) { return o.kind == element.kind; };
  if (element.kind != PlyElementKind::kOther &&
      std::any_of(header->elements.begin(), header->elements.end(), same_kind)) {
    text.fail("element " + element.name + " is announced twice");
  }
  if (element.kind == PlyElementKind::kVertex) header->vertex_count = element.count;
  header->elements.push_back(std::move(element));
}

// Appends a property to an element. Each coordinate, and the list of indices, may be there only
// once.
void addProperty(const MeshText& text, const PlyProperty& property, PlyElement* element) {
  if (property.role != PlyRole::kIgnored && hasRole(*element, property.role)) {
    text.fail("element " + element->name + " has this property twice");
  }
  element->properties.push_back(property);
}

}  // namespace

std::size_t sizeOf(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

PlyHeader readPlyHeader(const std::string& path, std::string_view content) {
  MeshText text(path, content, MeshTextRules{});
  const std::string_view magic = text.word();
  if (magic != "ply") text.failAt(magic, "'ply'");
  PlyHeader header;
  bool has_format = false;
  while (text.nextLine()) {
    const std::string_view keyword = text.word();
    if (keyword == "format") {
      header.format = readFormat(text);
      has_format = true;
    } else if (keyword == "element") {
      addElement(text, readElement(text), &header);
    } else if (keyword == "property") {
      if (header.elements.empty()) text.fail("a property before the first element");
      PlyElement& element = header.elements.back();
      addProperty(text, readProperty(text, element.kind), &element);
    } else if (keyword == "end_header") {
      if (!has_format) text.fail("the header has no 'format' line");
      for (const PlyElement& element : header.elements) requireRoles(text, element);
      // The records begin after the line of "end_header", whatever else is on that line.
      const std::size_t line_end = content.find('\n', text.offset());
      header.size = line_end == std::string_view::npos ? content.size() : line_end + 1;
      header.line_count = text.line();
      return header;
    } else if (keyword != "comment" && keyword != "obj_info") {
      text.failAt(keyword, "a PLY header's keyword");
    }
  }
  text.fail("the header does not end: no 'end_header'");
}

}  // namespace deformable_contact_monitor
