// Reads vertices, faces and triangle strips of an ascii or binary PLY file. Other elements and
// properties are skipped. The header (ply_header.h) tells how the records are laid out. PlyReader
// walks through all records once. It is a template over the encoding: BinaryBody and AsciiBody have
// the same functions.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/mesh_files/mesh_readers.h"
#include "core/mesh_files/mesh_text.h"
#include "core/mesh_files/ply_attributes.h"
#include "core/mesh_files/ply_header.h"
#include "core/mesh_files/polygons.h"

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

  // Skips the number -1 if it is next, and returns whether it was.
  bool skipsMinusOne(PlyType type) {
    const std::size_t begin = at_;
    if (number(type) == -1) return true;
    at_ = begin;
    return false;
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

  bool skipsMinusOne(PlyType) {
    MeshText ahead = text_;
    if (ahead.word() != "-1") return false;
    text_.word();
    return true;
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

// Reads the records of a file, each property by its role.
template <typename Body>
class PlyReader {
 public:
  PlyReader(Body body, const PlyHeader& header, MeshGroups* groups)
      : body_(std::move(body)), header_(header), attributes_(header, groups) {}

  TriangleMesh read(MeshFileReport* report) {
    for (const PlyElement& element : header_.elements) readElement(element);
    body_.end();
    polygons_.triangulate(mesh_.vertices, report);
    attributes_.addByVertices(mesh_.triangles);
    return std::move(mesh_);
  }

 private:
  // Checks the count against the size of the file before memory is allocated for it.
  void readElement(const PlyElement& element) {
    const auto shortest = std::max<std::uint64_t>(1, Body::shortestRecord(element));
    if (element.count > body_.remaining() / shortest) {
      body_.fail(std::to_string(element.count) + " elements " + element.name +
                 " announced, but the file is too short for them");
    }
    if (element.count >= kCountLimit) body_.fail("2^31 elements or more");
    const bool is_vertex = element.kind == PlyElementKind::kVertex;
    if (is_vertex) mesh_.vertices.reserve(3 * element.count);
    if (element.kind == PlyElementKind::kFace) mesh_.triangles.reserve(3 * element.count);
    for (std::uint64_t record = 0; record < element.count; ++record) {
      float coordinates[3] = {};
      const std::size_t first = mesh_.triangleCount();
      body_.beginRecord();
      for (const PlyProperty& property : element.properties) {
        readProperty(property, element.kind, coordinates);
      }
      body_.endRecord();
      attributes_.endRecord(element.kind, first, mesh_.triangleCount());
      if (is_vertex) mesh_.vertices.insert(mesh_.vertices.end(), coordinates, coordinates + 3);
    }
  }

  void readProperty(const PlyProperty& property, PlyElementKind kind, float* coordinates) {
    switch (property.role) {
      case PlyRole::kX:
        coordinates[0] = body_.real(property.type);
        break;
      case PlyRole::kY:
        coordinates[1] = body_.real(property.type);
        break;
      case PlyRole::kZ:
        coordinates[2] = body_.real(property.type);
        break;
      case PlyRole::kVertexIndices:
        kind == PlyElementKind::kStrips ? readStrips(property) : readFace(property);
        break;
      case PlyRole::kIgnored:
        if (float* const value = attributes_.valueOf(property)) {
          *value = body_.real(property.type);
          break;
        }
        body_.skip(property.type, property.is_list ? body_.count("the length of a list",
                                                                 property.count_type, kCountLimit)
                                                   : 1);
    }
  }

  std::uint32_t readIndex(const PlyProperty& property) {
    return static_cast<std::uint32_t>(
        body_.count("vertex index", property.type, header_.vertex_count));
  }

  void readFace(const PlyProperty& property) {
    const std::uint64_t size =
        body_.count("the number of a face's vertices", property.count_type, kCountLimit);
    if (size < 3) {
      body_.fail("a face needs 3 vertices or more, this one has " + std::to_string(size));
    }
    polygons_.begin();
    for (std::uint64_t i = 0; i < size; ++i) polygons_.add(readIndex(property));
  }

  // Reads one list of strips. Each vertex from the third on makes a triangle with the two before
  // it, of which every second one is turned round; the index -1 begins another strip. Triangles
  // that use a vertex twice only lead to the next part of a strip and are no surface.
  void readStrips(const PlyProperty& property) {
    const std::uint64_t size =
        body_.count("the number of a strip's vertices", property.count_type, kCountLimit);
    std::uint32_t a = 0, b = 0;
    std::uint64_t length = 0;
    for (std::uint64_t i = 0; i < size; ++i) {
      if (body_.skipsMinusOne(property.type)) {
        length = 0;
        continue;
      }
      const std::uint32_t c = readIndex(property);
      ++length;
      if (length >= 3 && a != b && b != c && a != c) {
        const bool is_turned = length % 2 == 0;
        mesh_.triangles.insert(mesh_.triangles.end(), {is_turned ? b : a, is_turned ? a : b, c});
      }
      a = b;
      b = c;
    }
  }

  Body body_;
  const PlyHeader& header_;
  TriangleMesh mesh_;
  PolygonList polygons_{&mesh_.triangles};
  PlyAttributes attributes_;
};

}  // namespace

TriangleMesh readPly(const std::string& path, std::string_view content, MeshFileReport* report,
                     MeshGroups* groups) {
  const PlyHeader header = readPlyHeader(path, content);
  if (header.format == PlyFormat::kAscii) {
    return PlyReader<AsciiBody>(AsciiBody(path, content, header), header, groups).read(report);
  }
  return PlyReader<BinaryBody>(BinaryBody(path, content, header), header, groups).read(report);
}

}  // namespace deformable_contact_monitor
