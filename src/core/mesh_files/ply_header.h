// The header of a PLY file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace deformable_contact_monitor {

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

// [bytes]
std::size_t sizeOf(PlyType type);

// What a mesh reader wants of a property.
enum class PlyRole { kIgnored, kX, kY, kZ, kVertexIndices };

struct PlyProperty {
  PlyType type = PlyType::kFloat;        // of a list: of its items
  PlyType count_type = PlyType::kUint8;  // of a list
  bool is_list = false;
  PlyRole role = PlyRole::kIgnored;
};

enum class PlyElementKind { kVertex, kFace, kOther };

struct PlyElement {
  PlyElementKind kind = PlyElementKind::kOther;
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;  // in file order
  std::uint64_t vertex_count = 0;
  std::size_t size = 0;        // offset of the first byte after the header
  std::size_t line_count = 0;  // lines of the header
};

// Throws std::runtime_error, "<path>:<line>: <what>", unless there is at most one vertex element,
// with one scalar x, y and z each, and at most one face element, with one list of vertex indices.
PlyHeader readPlyHeader(const std::string& path, std::string_view content);

}  // namespace deformable_contact_monitor
