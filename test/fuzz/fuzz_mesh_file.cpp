// Mesh files: OBJ, OFF, PLY, STL. The first byte is the format, and whether the others are the file
// or what a mostly well-formed one is made of.
#include <stdexcept>
#include <string>

#include "core/mesh_file.h"
#include "fuzz_target.h"
#include "mesh_writer.h"
#include "scratch_file.h"

namespace deformable_contact_monitor {
namespace {

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
    return true;
  } catch (const std::runtime_error& refusal) {
    requireThat(namesFile(refusal.what(), file), "a refusal does not name its file");
    return false;
  }
}

const FuzzTargetEntry entry("mesh_file", tryMeshFile);

}  // namespace
}  // namespace deformable_contact_monitor
