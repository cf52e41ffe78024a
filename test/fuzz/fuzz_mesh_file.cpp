// Mesh files: OBJ, OFF, PLY, STL. The first byte is the format, the others are the file.
#include <stdexcept>

#include "core/mesh_files/mesh_file.h"
#include "fuzz_target.h"
#include "scratch_file.h"

namespace deformable_contact_monitor {
namespace {

// Past the first check: the file is a mesh.
bool tryMeshFile(const std::uint8_t* data, std::size_t size) {
  static const ScratchFile files[] = {ScratchFile(".obj"), ScratchFile(".off"), ScratchFile(".ply"),
                                      ScratchFile(".stl")};
  if (size == 0) return false;
  const ScratchFile& file = files[data[0] % 4];
  file.write(data + 1, size - 1);
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
