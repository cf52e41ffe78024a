// Reads vertices and faces of an ascii or binary PLY file. Other elements and properties are
// skipped. The header (ply_header.h) tells how the records are laid out. readElements() walks
// through all records once. It is a template over the encoding: BinaryBody and AsciiBody have the
// same functions.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "core/mesh_files/mesh_readers.h"
#include "core/mesh_files/mesh_text.h"
#include "core/mesh_files/ply_header.h"

namespace deformable_contact_monitor {
namespace {

// Conversion of a double beyond the range of float must result in infinity.
static_assert(std::numeric_limits<float>::is_iec559 && std::numeric_limits<double>::is_iec559);
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);

// Counts of records and lengths of lists must be below this, so that indices fit 31 bits.
constexpr std::uint64_t kCountLimit = std::uint64_t{1} << 31;

// Reads the elements of a binary file. AsciiBody below has the same functions.
class BinaryBody {
 public:
  BinaryBody(const std::string& path, std::string_view content, const PlyHeader& header)
      : path_(path),
        content_(content),
        at_(header.size),
        swap_(header.format == PlyFormat::kBigEndian) {}

  float real(PlyType type) { return static_cast<float>(number(type)); }

  // Returns an integer in [0, limit).
  std::uint64_t count(const char* what, PlyType type, std::uint64_t limit) {
    const double value = number(type);
    if (!(value >= 0 && value < static_cast<double>(limit)) || value != std::floor(value)) {
      // The message shall name the byte at which the number begins.
      at_ -= sizeOf(type);
      fail(std::string(what) + " " + std::to_string(value) + " is out of range, must be in [0, " +
           std::to_string(limit) + ")");
    }
    return static_cast<std::uint64_t>(value);
  }

  // Skips that many numbers. The product cannot overflow, because `times` is below 2^31.
  void skip(PlyType type, std::uint64_t times) {
    require(times * sizeOf(type));
    at_ += times * sizeOf(type);
  }

  // Binary records follow one another without separators.
  void beginRecord() {}
  void endRecord() {}
  void end() {
    if (at_ != content_.size()) fail("more bytes than the header announces");
  }

  // Returns a size that no record of the element is below [bytes].
  static std::uint64_t shortestRecord(const PlyElement& element) {
    std::uint64_t size = 0;
    for (const PlyProperty& property : element.properties) {
      size += sizeOf(property.is_list ? property.count_type : property.type);
    }
    return size;
  }
  std::uint64_t remaining() const { return content_.size() - at_; }

  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(path_ + ": " + what + " (byte " + std::to_string(at_) + ")");
  }

 private:
  // Throws if fewer bytes are left.
  void require(std::uint64_t size) const {
    if (size > remaining()) fail("the file ends amid its elements");
  }

  // Copies a number out of the file, because it may be unaligned, and reverses the bytes of a
  // big-endian number.
  template <typename T>
  T take() {
    require(sizeof(T));
    char bytes[sizeof(T)];
    std::memcpy(bytes, content_.data() + at_, sizeof(T));
    if (swap_) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  // The values of every PLY type are exact as double, so nothing is rounded here.
  double number(PlyType type) {
    switch (type) {
      case PlyType::kInt8:
        return take<std::int8_t>();
      case PlyType::kUint8:
        return take<std::uint8_t>();
      case PlyType::kInt16:
        return take<std::int16_t>();
      case PlyType::kUint16:
        return take<std::uint16_t>();
      case PlyType::kInt32:
        return take<std::int32_t>();
      case PlyType::kUint32:
        return take<std::uint32_t>();
      case PlyType::kFloat:
        return static_cast<double>(take<float>());
      default:
        return take<double>();
    }
  }

  const std::string& path_;
  std::string_view content_;
  std::size_t at_;
  bool swap_;
};

// Reads the elements of an ascii file, one on each line.
class AsciiBody {
 public:
  AsciiBody(const std::string& path, std::string_view content, const PlyHeader& header)
      : text_(path, content.substr(header.size), MeshTextRules{}, header.line_count + 1) {}

  float real(PlyType) { return text_.real("a number"); }

  std::uint64_t count(const char* what, PlyType, std::uint64_t limit) {
    return text_.count(what, limit);
  }

  void skip(PlyType, std::uint64_t times) {
    for (std::uint64_t i = 0; i < times; ++i) text_.real("a number");
  }

  void beginRecord() {
    if (!text_.skipToWord()) text_.fail("the file ends amid its elements");
  }
  void endRecord() {
    if (!text_.atLineEnd()) text_.failAt(text_.word(), "the end of the line");
  }
  void end() {
    if (text_.skipToWord()) text_.fail("more lines than the header announces");
  }

  static std::uint64_t shortestRecord(const PlyElement& element) {
    return 2 * element.properties.size();  // each has at least a digit and a blank
  }
  std::uint64_t remaining() const {
    return text_.remaining() + 1;
  }  // the last blank may be missing

  [[noreturn]] void fail(const std::string& what) const { text_.fail(what); }

 private:
  MeshText text_;
};

template <typename Body>
void readFaceIndices(Body& body, const PlyProperty& property, std::uint64_t vertex_count,
                     TriangleMesh* mesh) {
  const std::uint64_t size =
      body.count("the number of a face's vertices", property.count_type, kCountLimit);
  if (size < 3) body.fail("a face needs 3 vertices or more, this one has " + std::to_string(size));
  PolygonFan fan(&mesh->triangles);
  for (std::uint64_t i = 0; i < size; ++i) {
    fan.add(static_cast<std::uint32_t>(body.count("vertex index", property.type, vertex_count)));
  }
}

template <typename Body>
void readProperty(Body& body, const PlyProperty& property, const PlyHeader& header,
                  float* coordinates, TriangleMesh* mesh) {
  switch (property.role) {
    case PlyRole::kX:
      coordinates[0] = body.real(property.type);
      break;
    case PlyRole::kY:
      coordinates[1] = body.real(property.type);
      break;
    case PlyRole::kZ:
      coordinates[2] = body.real(property.type);
      break;
    case PlyRole::kVertexIndices:
      readFaceIndices(body, property, header.vertex_count, mesh);
      break;
    case PlyRole::kIgnored:
      body.skip(property.type, property.is_list ? body.count("the length of a list",
                                                             property.count_type, kCountLimit)
                                                : 1);
  }
}

template <typename Body>
TriangleMesh readElements(Body body, const PlyHeader& header) {
  TriangleMesh mesh;
  for (const PlyElement& element : header.elements) {
    // Checks the count against the size of the file before memory is allocated for it.
    const auto shortest = std::max<std::uint64_t>(1, Body::shortestRecord(element));
    if (element.count > body.remaining() / shortest) {
      body.fail(std::to_string(element.count) + " elements " + element.name +
                " announced, but the file is too short for them");
    }
    if (element.count >= kCountLimit) body.fail("2^31 elements or more");
    const bool is_vertex = element.kind == PlyElementKind::kVertex;
    if (is_vertex) mesh.vertices.reserve(3 * element.count);
    if (element.kind == PlyElementKind::kFace) mesh.triangles.reserve(3 * element.count);
    for (std::uint64_t record = 0; record < element.count; ++record) {
      float coordinates[3] = {};
      body.beginRecord();
      for (const PlyProperty& property : element.properties) {
        readProperty(body, property, header, coordinates, &mesh);
      }
      body.endRecord();
      if (is_vertex) mesh.vertices.insert(mesh.vertices.end(), coordinates, coordinates + 3);
    }
  }
  body.end();
  return mesh;
}

}  // namespace

TriangleMesh readPly(const std::string& path, std::string_view content) {
  const PlyHeader header = readPlyHeader(path, content);
  if (header.format == PlyFormat::kAscii) {
    return readElements(AsciiBody(path, content, header), header);
  }
  return readElements(BinaryBody(path, content, header), header);
}

}  // namespace deformable_contact_monitor
