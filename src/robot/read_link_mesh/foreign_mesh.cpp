// Reads a file with the reader of its format: those of core/mesh_files, so that a file is the same
// mesh as a link and elsewhere, or Assimp for COLLADA.
#include "robot/read_link_mesh/foreign_mesh.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "core/mesh_files/mesh_readers.h"
#include "robot/mesh_stream.h"
#include "robot/read_link_mesh/read_collada.h"
#include "robot/reading_limits.h"
#include "robot/regular_file.h"

namespace deformable_contact_monitor {
namespace {

// Returns the file name's ending in small letters, with its dot.
std::string endingOf(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

SourceMesh withNotes(SourceMesh mesh, const MeshFileReport& report) {
  for (const std::string& note : report.notes) {
    mesh.note += (mesh.note.empty() ? "" : "; ") + note;
  }
  return mesh;
}

SourceMesh toSourceMesh(const TriangleMesh& mesh) {
  if (!fitsMeshLimit(mesh.vertexCount(), mesh.triangleCount(), kMaxMeshMib * kBytesPerMib)) {
    throw std::length_error("more than " + std::to_string(kMaxMeshMib) +
                            " MiB of vertices and triangles");
  }
  SourceMesh source;
  source.vertices.reserve(mesh.vertexCount());
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i) {
    const Vec3d v = toDouble(mesh.vertex(i));
    source.vertices.emplace_back(v.x, v.y, v.z);
  }
  source.triangles.reserve(mesh.triangleCount());
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    source.triangles.push_back({mesh.triangles[i], mesh.triangles[i + 1], mesh.triangles[i + 2]});
  }
  return source;
}

// The readers' errors begin with the name that they are given and, of texts, the line: ":12: what".
std::string withLineInWords(const std::string& error) {
  const std::size_t number = error.find_first_not_of(':');
  const std::size_t end = std::min(error.find(": ", number), error.size());
  const bool has_line =
      number == 1 && error.find_first_not_of("0123456789", number) == end && end > number;
  if (has_line) return "line " + error.substr(number, end - number) + error.substr(end);
  return error.substr(std::min(error.find_first_not_of(": "), error.size()));
}

}  // namespace

SourceMesh readForeignMesh(const std::string& path) {
  const std::string ending = endingOf(path);
  const bool is_collada = ending == ".dae";
  if (!is_collada && !isMeshFileName(path)) {
    throw std::runtime_error("'" + ending +
                             "' is no mesh format of robot links: STL, DAE, OBJ, PLY and OFF are");
  }
  const std::string bytes = readRegularFile(path);
  MeshFileReport report;
  if (is_collada) {
    SourceMesh mesh = readCollada(bytes, &report);
    return withNotes(std::move(mesh), report);
  }
  // The caller knows the path, so another name takes its place and is taken out of the error.
  const std::string name = "mesh" + ending;
  try {
    const TriangleMesh mesh = readMeshContent(name, bytes, &report);
    return withNotes(toSourceMesh(mesh), report);
  } catch (const std::runtime_error& error) {
    const std::string text = error.what();
    const bool has_name = text.compare(0, name.size(), name) == 0;
    throw std::runtime_error(has_name ? withLineInWords(text.substr(name.size())) : text);
  }
}

}  // namespace deformable_contact_monitor
