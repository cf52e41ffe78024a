// Reads ascii OFF files and their variants with texture coordinates, colours and normals (STOFF,
// COFF, NOFF, CNOFF). The file has a keyword, the numbers of vertices, faces and edges, and then
// one line for each vertex and each face. The additional values of the variants follow the
// coordinates on the same line, so they are skipped with the rest of the line.
#include <algorithm>

#include "core/mesh_files/mesh_readers.h"
#include "core/mesh_files/mesh_text.h"
#include "core/mesh_files/polygons.h"

namespace deformable_contact_monitor {
namespace {

// Counts must be below this, so that indices fit 31 bits.
constexpr std::uint64_t kCountLimit = std::uint64_t{1} << 31;

// Throws if the counts do not fit the size of the file. It is called before memory is allocated.
// `shortest_line` is the least number of bytes that one vertex or face takes: "0 0 0" or "3 0 0 0",
// with a line end.
void checkFits(const MeshText& text, std::uint64_t count, std::uint64_t shortest_line,
               const char* things) {
  if (count > text.remaining() / shortest_line + 1) {
    text.fail(std::to_string(count) + " " + things + " announced, but the file has only " +
              std::to_string(text.remaining()) + " more bytes");
  }
}

// Reads the keyword, which must be there. Other variants, such as 4OFF, are rejected.
void readHeaderWord(MeshText& text) {
  const bool any = text.skipToWord();
  const std::string_view keyword = any ? text.word() : std::string_view();
  constexpr std::string_view kKnown[] = {"OFF", "COFF", "NOFF", "CNOFF", "STOFF"};
  if (std::find(std::begin(kKnown), std::end(kKnown), keyword) == std::end(kKnown)) {
    text.failAt(keyword, "OFF, COFF, NOFF, CNOFF or STOFF");
  }
}

}  // namespace

TriangleMesh readOff(const std::string& path, std::string_view content, MeshFileReport* report,
                     MeshGroups* /*groups*/) {
  MeshText text(path, content, MeshTextRules{true, false});
  readHeaderWord(text);
  if (!text.skipToWord()) text.failAt({}, "the number of vertices");
  const std::uint64_t vertex_count = text.count("the number of vertices", kCountLimit);
  const std::uint64_t face_count = text.count("the number of faces", kCountLimit);
  // The number of edges is not used, and many programs leave it out.
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
  PolygonList polygons(&mesh.triangles);
  for (std::uint64_t f = 0; f < face_count; ++f) {
    if (!text.nextLine()) {
      text.fail("the file ends after " + std::to_string(f) + " of " + std::to_string(face_count) +
                " faces");
    }
    const std::uint64_t size = text.count("the number of a face's vertices", kCountLimit);
    if (size < 3) {
      text.fail("a face needs 3 vertices or more, this one has " + std::to_string(size));
    }
    polygons.begin();
    for (std::uint64_t i = 0; i < size; ++i) {
      polygons.add(static_cast<std::uint32_t>(text.count("vertex index", vertex_count)));
    }
  }
  if (text.nextLine()) text.fail("more lines than the counts at the top announce");
  polygons.triangulate(mesh.vertices, report);
  return mesh;
}

}  // namespace deformable_contact_monitor
