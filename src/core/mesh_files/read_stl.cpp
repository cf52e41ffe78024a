// STL, binary and ascii. Three vertices of its own for every facet, in file order.
#include <cstring>
#include <stdexcept>

#include "core/mesh_files/mesh_readers.h"
#include "core/mesh_files/mesh_text.h"

namespace deformable_contact_monitor {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "binary STL is little-endian");

constexpr std::size_t kHeaderSize = 84;  // of it, 80 bytes of text
constexpr std::size_t kFacetSize = 50;   // normal, three vertices, two more bytes

std::size_t binaryFacetCount(std::string_view content) {
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + kHeaderSize - sizeof count, sizeof count);
  return count;
}

TriangleMesh readBinary(std::string_view content) {
  const std::size_t count = binaryFacetCount(content);
  TriangleMesh mesh;
  mesh.vertices.resize(9 * count);
  mesh.triangles.resize(3 * count);
  for (std::size_t f = 0; f < count; ++f) {
    const char* facet = content.data() + kHeaderSize + kFacetSize * f;
    std::memcpy(&mesh.vertices[9 * f], facet + 3 * sizeof(float), 9 * sizeof(float));
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    mesh.triangles[i] = static_cast<std::uint32_t>(i);
  }
  return mesh;
}

void expect(MeshText& text, const char* keyword) {
  const std::string_view word = text.wordOnAnyLine();
  if (!equalIgnoringCase(word, keyword)) text.failAt(word, quoted(keyword));
}

void readFacet(MeshText& text, TriangleMesh* mesh) {
  expect(text, "normal");
  for (int i = 0; i < 3; ++i) text.wordOnAnyLine();  // whatever it says, the vertices decide
  expect(text, "outer");
  expect(text, "loop");
  for (int v = 0; v < 3; ++v) {
    expect(text, "vertex");
    for (int i = 0; i < 3; ++i) mesh->vertices.push_back(text.real("a coordinate"));
    mesh->triangles.push_back(static_cast<std::uint32_t>(mesh->triangles.size()));
  }
  expect(text, "endloop");
  expect(text, "endfacet");
}

// One solid after the other, each with a name up to the end of its line.
TriangleMesh readAscii(const std::string& path, std::string_view content) {
  MeshText text(path, content, MeshTextRules{});
  TriangleMesh mesh;
  bool any = text.skipToWord();
  while (any) {
    expect(text, "solid");
    text.nextLine();
    std::string_view word = text.word();
    for (; equalIgnoringCase(word, "facet"); word = text.wordOnAnyLine()) readFacet(text, &mesh);
    if (!equalIgnoringCase(word, "endsolid")) text.failAt(word, "'facet' or 'endsolid'");
    any = text.nextLine();
  }
  return mesh;
}

bool beginsAscii(const std::string& path, std::string_view content) {
  const std::string_view start = content.substr(0, kHeaderSize);
  const std::string_view word = MeshText(path, start, MeshTextRules{}).wordOnAnyLine();
  return equalIgnoringCase(word, "solid") && start.find('\0') == std::string_view::npos;
}

}  // namespace

// Many binary files begin with "solid" too, so the size decides first.
TriangleMesh readStl(const std::string& path, std::string_view content) {
  const bool has_header = content.size() >= kHeaderSize;
  if (has_header && content.size() == kHeaderSize + kFacetSize * binaryFacetCount(content)) {
    return readBinary(content);
  }
  if (beginsAscii(path, content)) return readAscii(path, content);
  if (!has_header) {
    throw std::runtime_error(
        path + ": neither ascii STL (no 'solid' at its start) nor binary STL " +
        "(shorter than the header; ends at byte " + std::to_string(content.size()) + ")");
  }
  const std::size_t count = binaryFacetCount(content);
  throw std::runtime_error(
      path + ": binary STL of " + std::to_string(count) + " facets would have " +
      std::to_string(kHeaderSize + kFacetSize * count) + " bytes, this file has " +
      std::to_string(content.size()) + " (count at byte 80)");
}

}  // namespace deformable_contact_monitor
