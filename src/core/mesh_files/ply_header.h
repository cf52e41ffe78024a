// Reads the header of a PLY file, which lists the elements of the file and their properties. The
// header is ascii text in binary files too. It ends with the line "end_header". Then the records of
// all elements follow, in the order in which the header lists elements, and each record has its
// numbers in the order of the element's properties.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace deformable_contact_monitor {

// The encoding of the records.
enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };

// The types of numbers. Each has two names in files, such as "uchar" and "uint8".
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

// Returns the size of a number [bytes].
std::size_t sizeOf(PlyType type);

// The meaning of a property for a mesh reader.
enum class PlyRole { kIgnored, kX, kY, kZ, kVertexIndices };

// A property is one number, or a list of numbers, in each record of an element.
struct PlyProperty {
  PlyType type = PlyType::kFloat;        // of a list: the type of its items
  PlyType count_type = PlyType::kUint8;  // of a list: the type of its length
  bool is_list = false;
  PlyRole role = PlyRole::kIgnored;
  std::string name;
};

// Vertices, faces and triangle strips are read; records of other elements are skipped.
enum class PlyElementKind { kVertex, kFace, kStrips, kOther };

// An element is a table of `count` records that all have the same properties.
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

// Returns the header. Throws std::runtime_error, "<path>:<line>: <what>", unless there is at most
// one vertex element, with one scalar x, y and z each, and at most one element of faces and one of
// triangle strips (tristrips), with one list of vertex indices each.
PlyHeader readPlyHeader(const std::string& path, std::string_view content);

}  // namespace deformable_contact_monitor
