// Reads binary and ascii STL files. Every facet gets three vertices of its own, in file order. A
// binary file has 80 bytes of any text, the number of facets, and then the facets. An ascii file
// has one or more solids, each a list of facets. The normals in the file are ignored, because the
// order of a facet's vertices tells which side is outside.
#include <cstring>
#include <stdexcept>

#include "core/mesh_files/mesh_readers.h"
#include "core/mesh_files/mesh_text.h"

namespace deformable_contact_monitor {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "binary STL is little-endian");

constexpr std::size_t kHeaderSize = 84;  // 80 bytes of text and a count [bytes]
constexpr std::size_t kFacetSize = 50;   // normal, three vertices and two more bytes [bytes]

// Returns the number of facets that the header announces. The content must be as long as a header.
std::size_t binaryFacetCount(std::string_view content) {
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + kHeaderSize - sizeof count, sizeof count);
  return count;
}

// The content must have at least the size that its header announces.
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

// Reads the next word, on any line, and throws if it is not the keyword.
void expect(MeshText& text, const char* keyword) {
  const std::string_view word = text.wordOnAnyLine();
  if (!equalIgnoringCase(word, keyword)) text.failAt(word, quoted(keyword));
}

// Reads "endloop" or the like, which some programs write as two words, and throws if it is not
// there. `word` is the next word.
void expectEnd(MeshText& text, std::string_view word, const char* of, const std::string& wanted) {
  if (equalIgnoringCase(word, std::string("end") + of)) return;
  if (!equalIgnoringCase(word, "end")) text.failAt(word, wanted);
  expect(text, of);
}

// Reads a facet whose keyword "facet" was just read.
void readFacet(MeshText& text, TriangleMesh* mesh) {
  expect(text, "normal");
  for (int i = 0; i < 3; ++i) text.wordOnAnyLine();  // the normal in the file is ignored
  expect(text, "outer");
  expect(text, "loop");
  for (int v = 0; v < 3; ++v) {
    expect(text, "vertex");
    for (int i = 0; i < 3; ++i) mesh->vertices.push_back(text.real("a coordinate"));
    mesh->triangles.push_back(static_cast<std::uint32_t>(mesh->triangles.size()));
  }
  expectEnd(text, text.wordOnAnyLine(), "loop", "'endloop'");
  expectEnd(text, text.wordOnAnyLine(), "facet", "'endfacet'");
}

// Reads one solid after the other. The name of a solid goes to the end of its line. DOS programs
// end a text with Ctrl-Z, and others fill their blocks with zero bytes.
TriangleMesh readAscii(const std::string& path, std::string_view content) {
  constexpr std::string_view kFiller("\0\x1a", 2);
  content = content.substr(0, content.find_last_not_of(kFiller) + 1);
  MeshText text(path, content, MeshTextRules{});
  TriangleMesh mesh;
  bool any = text.skipToWord();
  while (any) {
    expect(text, "solid");
    text.nextLine();
    std::string_view word = text.word();
    for (; equalIgnoringCase(word, "facet"); word = text.wordOnAnyLine()) readFacet(text, &mesh);
    expectEnd(text, word, "solid", "'facet' or 'endsolid'");
    any = text.nextLine();
  }
  return mesh;
}

// Returns whether the file begins like an ascii file. Text has no NUL, but a binary header mostly
// does.
bool beginsAscii(const std::string& path, std::string_view content) {
  const std::string_view start = content.substr(0, kHeaderSize);
  const std::string_view word = MeshText(path, start, MeshTextRules{}).wordOnAnyLine();
  return equalIgnoringCase(word, "solid") && start.find('\0') == std::string_view::npos;
}

}  // namespace

// Many binary files begin with "solid" too, so the size decides first. Less bytes than a facet has,
// or zeros, may follow the last facet. More than that may be facets that were not counted.
TriangleMesh readStl(const std::string& path, std::string_view content, MeshFileReport* report,
                     MeshGroups* /*groups*/) {
  const bool has_header = content.size() >= kHeaderSize;
  const std::size_t count = has_header ? binaryFacetCount(content) : 0;
  const std::size_t size = kHeaderSize + kFacetSize * count;
  if (has_header && content.size() == size) return readBinary(content);
  if (beginsAscii(path, content)) return readAscii(path, content);
  if (!has_header) {
    throw std::runtime_error(
        path + ": neither ascii STL (no 'solid' at its start) nor binary STL " +
        "(shorter than the header; ends at byte " + std::to_string(content.size()) + ")");
  }
  const std::string facets = "binary STL of " + std::to_string(count) + " facets";
  if (content.size() < size) {
    throw std::runtime_error(path + ": " + facets + " would have " + std::to_string(size) +
                             " bytes, this file has " + std::to_string(content.size()) +
                             " (count at byte 80)");
  }
  const std::string_view rest = content.substr(size);
  const std::string behind = std::to_string(rest.size()) + " bytes behind its last facet";
  if (rest.size() >= kFacetSize && rest.find_first_not_of('\0') != std::string_view::npos) {
    throw std::runtime_error(path + ": " + facets + " (count at byte 80) with " + behind +
                             ": the count is wrong, or something else was appended");
  }
  report->notes.push_back(facets + " with " + behind + ", which are ignored");
  return readBinary(content);
}

}  // namespace deformable_contact_monitor
