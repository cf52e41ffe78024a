// OFF and its variants with texture coordinates, colours and normals (STOFF, COFF, NOFF, CNOFF).
#include <algorithm>

#include "core/mesh_files/mesh_readers.h"
#include "core/mesh_files/mesh_text.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint64_t kCountLimit = std::uint64_t{1} << 31;

// No allocation before the counts are known to fit the file.
void checkFits(const MeshText& text, std::uint64_t count, std::uint64_t shortest_line,
               const char* things) {
  if (count > text.remaining() / shortest_line + 1) {
    text.fail(std::to_string(count) + " " + things + " announced, but the file has only " +
              std::to_string(text.remaining()) + " more bytes");
  }
}

void readHeaderWord(MeshText& text) {
  const bool any = text.skipToWord();
  const std::string_view keyword = any ? text.word() : std::string_view();
  constexpr std::string_view kKnown[] = {"OFF", "COFF", "NOFF", "CNOFF", "STOFF"};
  if (std::find(std::begin(kKnown), std::end(kKnown), keyword) == std::end(kKnown)) {
    text.failAt(keyword, "OFF, COFF, NOFF, CNOFF or STOFF");
  }
}

}  // namespace

TriangleMesh readOff(const std::string& path, std::string_view content) {
  MeshText text(path, content, MeshTextRules{true, false});
  readHeaderWord(text);
  if (!text.skipToWord()) text.failAt({}, "the number of vertices");
  const std::uint64_t vertex_count = text.count("the number of vertices", kCountLimit);
  const std::uint64_t face_count = text.count("the number of faces", kCountLimit);
  // The number of edges, which nobody fills in, may be missing.
  if (!text.atLineEnd()) text.count("the number of edges", UINT64_MAX);
  if (!text.atLineEnd()) text.failAt(text.word(), "the end of the line");

  TriangleMesh mesh;
  checkFits(text, vertex_count, 6, "vertices");
  mesh.vertices.reserve(3 * vertex_count);
  for (std::uint64_t v = 0; v < vertex_count; ++v) {
    if (!text.nextLine()) {
      text.fail("the file ends after " + std::to_string(v) + " of " + std::to_string(vertex_count) +
                " vertices");
    }
    for (int i = 0; i < 3; ++i) mesh.vertices.push_back(text.real("a coordinate"));
  }

  checkFits(text, face_count, 8, "faces");
  mesh.triangles.reserve(3 * face_count);
  for (std::uint64_t f = 0; f < face_count; ++f) {
    if (!text.nextLine()) {
      text.fail("the file ends after " + std::to_string(f) + " of " + std::to_string(face_count) +
                " faces");
    }
    const std::uint64_t size = text.count("the number of a face's vertices", kCountLimit);
    if (size < 3) {
      text.fail("a face needs 3 vertices or more, this one has " + std::to_string(size));
    }
    PolygonFan fan(&mesh.triangles);
    for (std::uint64_t i = 0; i < size; ++i) {
      fan.add(static_cast<std::uint32_t>(text.count("vertex index", vertex_count)));
    }
  }
  if (text.nextLine()) text.fail("more lines than the counts at the top announce");
  return mesh;
}

}  // namespace deformable_contact_monitor
