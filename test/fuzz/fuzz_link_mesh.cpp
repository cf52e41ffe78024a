// Mesh files of links, as the child reads them: our checks, then Assimp, in this process. The first
// byte is the format, the others are the file. Assimp's crashes show here too; test/fuzz/run tells
// them from ours by their stacks, and in the product they end the child alone.
#include <stdexcept>

#include "fuzz_target.h"
#include "robot/read_link_mesh/assimp_mesh.h"
#include "scratch_file.h"

namespace deformable_contact_monitor {
namespace {

// Past the first check: the file is a mesh.
bool tryLinkMesh(const std::uint8_t* data, std::size_t size) {
  static const ScratchFile files[] = {ScratchFile(".stl"), ScratchFile(".obj"),
                                      ScratchFile(".dae")};
  if (size == 0) return false;
  const ScratchFile& file = files[data[0] % 3];
  file.write(data + 1, size - 1);
  try {
    const SourceMesh mesh = readWithAssimp(file.path());
    requireThat(!mesh.triangles.empty(), "a mesh without a triangle");
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t corner : triangle) {
        requireThat(corner < mesh.vertices.size(), "an index out of range");
      }
    }
    return true;
  } catch (const std::runtime_error& refusal) {
    requireThat(*refusal.what() != '\0', "a refusal without a reason");
    return false;
  } catch (const std::bad_alloc&) {
    return false;  // the child says so
  }
}

const FuzzTargetEntry entry("link_mesh", tryLinkMesh);

}  // namespace
}  // namespace deformable_contact_monitor
