// Mesh files: OBJ, OFF, PLY, STL. The first byte is the format, and whether the others are the file
// or what a mostly well-formed one is made of.
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mesh_file.h"
#include "fuzz_target.h"
#include "mesh_writer.h"
#include "scratch_file.h"

namespace deformable_contact_monitor {
namespace {

// A group has triangles of the mesh, ascending; a file without it is refused by its name.
void checkGroup(const ScratchFile& file, const TriangleMesh& mesh, const std::string& name) {
  try {
    std::vector<TriangleRanges> groups;
    readMeshGroups(file.path(), {name}, &groups);
    std::uint64_t next = 0;
    for (const auto& [first, last] : groups.at(0)) {
      requireThat(first >= next && last >= first && last < mesh.triangleCount(),
                  "a group's ranges");
      next = std::uint64_t{last} + 2;
    }
  } catch (const std::runtime_error& refusal) {
    requireThat(namesFile(refusal.what(), file), "a refusal of groups does not name its file");
  }
}

// Past the first check: the file is a mesh.
bool tryMeshFile(const std::uint8_t* data, std::size_t size) {
  constexpr std::string (*kWriters[])(ByteSource*) = {objFrom, offFrom, plyFrom, stlFrom};
  constexpr std::uint8_t kMade = 128;
  static const ScratchFile files[] = {ScratchFile(".obj"), ScratchFile(".off"), ScratchFile(".ply"),
                                      ScratchFile(".stl")};
  if (size == 0) return false;
  const std::size_t format = data[0] % 4;
  const ScratchFile& file = files[format];
  ByteSource source(data + 1, size - 1);
  const std::string content = data[0] < kMade ? source.text(size) : kWriters[format](&source);
  file.write(content.data(), content.size());
  try {
    const TriangleMesh mesh = readMeshFile(file.path());
    requireThat(!mesh.triangles.empty(), "a mesh without a triangle");
    validate(mesh, "a mesh that was read");
    for (const char* group : {"a", "quality=1"}) checkGroup(file, mesh, group);
    return true;
  } catch (const std::runtime_error& refusal) {
    requireThat(namesFile(refusal.what(), file), "a refusal does not name its file");
    return false;
  }
}

const FuzzTargetEntry entry("mesh_file", tryMeshFile);

}  // namespace
}  // namespace deformable_contact_monitor
