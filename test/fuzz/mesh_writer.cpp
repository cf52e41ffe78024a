// Mesh files that are mostly well-formed, made of an input's bytes.
#include "mesh_writer.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "text_writer.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMostVertices = 12, kMostFaces = 10, kMostCorners = 4;

std::size_t vertexCount(ByteSource* source) { return 3 + source->below(kMostVertices); }
std::size_t faceCount(ByteSource* source) { return 1 + source->below(kMostFaces); }
std::size_t cornerCount(ByteSource* source) { return 3 + source->below(kMostCorners); }

// A value of one of PLY's types, as text or as bytes.
class PlyValue {
 public:
  PlyValue(std::size_t type, std::size_t format) : type_(type), format_(format) {}

  void append(double value, std::string* to) const {
    if (format_ == 0) {
      *to += std::to_string(value) + " ";
      return;
    }
    switch (type_) {
      case 0:
        return appendBytes(static_cast<float>(value), to);
      case 1:
        return appendBytes(value, to);
      case 2:
        return appendBytes(static_cast<std::uint8_t>(static_cast<std::int64_t>(value)), to);
      case 3:
        return appendBytes(static_cast<std::uint16_t>(static_cast<std::int64_t>(value)), to);
      default:
        return appendBytes(static_cast<std::uint32_t>(static_cast<std::int64_t>(value)), to);
    }
  }
  void append(long value, std::string* to) const {
    if (format_ == 0) {
      *to += std::to_string(value) + " ";
    } else {
      append(static_cast<double>(value), to);
    }
  }

 private:
  template <typename T>
  void appendBytes(T value, std::string* to) const {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    if (format_ == 2) std::reverse(std::begin(bytes), std::end(bytes));
    to->append(bytes, sizeof value);
  }

  std::size_t type_, format_;
};

constexpr std::array kPlyTypes = {"float", "double", "uchar", "ushort", "int", "uint"};

std::string plyHeader(ByteSource* source, std::size_t format, const char* real, std::size_t count,
                      const char* index, std::size_t vertices, std::size_t faces) {
  constexpr std::array kFormats = {"ascii", "binary_little_endian", "binary_big_endian"};
  std::string text = std::string("ply\nformat ") + kFormats.at(format) + " 1.0\ncomment c\n";
  text += "element vertex " + countText(source, vertices) + "\n";
  for (const char* const axis : {"x", "y", "z"}) {
    text += std::string("property ") + real + " " + axis + "\n";
  }
  text += "property uchar quality\nelement face " + countText(source, faces) + "\nproperty list ";
  return text + kPlyTypes.at(count) + " " + index + " vertex_indices\nend_header\n";
}

}  // namespace

std::string objFrom(ByteSource* source) {
  std::string text = "# c\no a\n";
  const std::size_t vertices = vertexCount(source);
  for (std::size_t i = 0; i < vertices; ++i) text += "v " + numberTexts(source, 3) + "\n";
  text += "vt 0 0\nvn 0 0 1\n";
  for (std::size_t left = faceCount(source); left > 0; --left) {
    constexpr const char* kOther[] = {"g a b\n", "s 1\n",          "usemtl m\n", "# f 1 2 3\n",
                                      "l 1 2\n", "vn 1 0 nan\r\n", "\\\n",       "\n"};
    const std::size_t other = source->below(4 * std::size(kOther));
    if (other < std::size(kOther)) text += kOther[other];
    text += "f";
    const std::size_t corners = cornerCount(source);
    constexpr const char* kAfter[] = {"", "", "/1", "//1", "/1/1", "/-1/-1", "/"};
    const char* const after = kAfter[source->below(std::size(kAfter))];
    const bool is_backward = source->flag();
    for (std::size_t i = 0; i < corners; ++i) {
      const long index = 1 + indexFrom(source, vertices);
      text += " " + std::to_string(is_backward ? -index : index) + after;
    }
    text += "\n";
  }
  return text;
}

std::string offFrom(ByteSource* source) {
  constexpr const char* kStarts[] = {"OFF\n", "OFF ", "# c\nOFF\n", "COFF\n", "NOFF\n", ""};
  std::string text = kStarts[std::min<std::size_t>(source->below(16), 5) % 3];
  const std::size_t vertices = vertexCount(source), faces = faceCount(source);
  text += countText(source, vertices) + " " + countText(source, faces) + " 0\n";
  for (std::size_t i = 0; i < vertices; ++i) text += numberTexts(source, 3) + "\n";
  for (std::size_t i = 0; i < faces; ++i) {
    const std::size_t corners = cornerCount(source);
    text += countText(source, corners);
    for (std::size_t k = 0; k < corners; ++k) {
      text += " " + std::to_string(indexFrom(source, vertices));
    }
    text += source->flag() ? " 255 0 0\n" : "\n";
  }
  return text;
}

std::string plyFrom(ByteSource* source) {
  const std::size_t format = source->below(3), real = source->below(2);
  const std::size_t count = 2 + source->below(4), index = 2 + source->below(4);
  const std::size_t vertices = vertexCount(source), faces = faceCount(source);
  std::string text =
      plyHeader(source, format, kPlyTypes.at(real), count, kPlyTypes.at(index), vertices, faces);
  const PlyValue real_value(real, format), quality(2, format), count_value(count, format);
  const PlyValue index_value(index, format);
  const char* const end = format == 0 ? "\n" : "";
  for (std::size_t i = 0; i < vertices; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      real_value.append(double{source->coordinate()}, &text);
    }
    quality.append(7L, &text);
    text += end;
  }
  for (std::size_t i = 0; i < faces; ++i) {
    const std::size_t corners = cornerCount(source);
    count_value.append(static_cast<long>(corners), &text);
    for (std::size_t k = 0; k < corners; ++k) {
      index_value.append(indexFrom(source, vertices), &text);
    }
    text += end;
  }
  return text;
}

std::string stlFrom(ByteSource* source) {
  const std::size_t faces = faceCount(source);
  std::string text;
  if (source->flag()) {
    text = "solid a\n";
    for (std::size_t i = 0; i < faces; ++i) {
      text += "facet normal " + numberTexts(source, 3) + "\nouter loop\n";
      for (int k = 0; k < 3; ++k) text += "vertex " + numberTexts(source, 3) + "\n";
      text += "endloop\nendfacet\n";
    }
    return text + "endsolid a\n";
  }
  constexpr std::size_t kStart = 80;
  text = source->flag() ? "solid, and binary" : "binary";
  text.resize(kStart, ' ');
  const PlyValue real(0, 1), count(4, 1), attribute(3, 1);
  count.append(static_cast<long>(faces), &text);
  for (std::size_t i = 0; i < faces; ++i) {
    for (int k = 0; k < 12; ++k) real.append(double{source->coordinate()}, &text);
    attribute.append(0L, &text);
  }
  return text;
}

}  // namespace deformable_contact_monitor
