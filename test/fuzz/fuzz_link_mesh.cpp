// Mesh files of links. The first byte is the format, and whether the others are the file or what a
// mostly well-formed one is made of. Under libFuzzer they are read as the child reads them, but in
// this process: by our readers, or COLLADA by our checks and Assimp. Then Assimp's crashes show
// too, and test/fuzz/run tells them from ours by their stacks. Elsewhere the child reads them, as
// in the product, where its crash is a refusal.
#include <stdexcept>
#include <string>

#include "fuzz_target.h"
#include "mesh_writer.h"
#include "robot/link_mesh_files.h"
#include "robot/read_link_mesh/foreign_mesh.h"
#include "scratch_file.h"

namespace deformable_contact_monitor {
namespace {

SourceMesh readFile(const std::string& path) {
#ifdef DCM_FUZZ_WITHOUT_CHILD
  return readForeignMesh(path);
#else
  return readLinkMeshFile(path);
#endif
}

// Past the first check: the file is a mesh.
bool tryLinkMesh(const std::uint8_t* data, std::size_t size) {
  constexpr std::string (*kWriters[])(ByteSource*) = {stlFrom, objFrom, daeFrom};
  constexpr std::uint8_t kMade = 128;
  static const ScratchFile files[] = {ScratchFile(".stl"), ScratchFile(".obj"),
                                      ScratchFile(".dae")};
  if (size == 0) return false;
  const std::size_t format = data[0] % 3;
  const ScratchFile& file = files[format];
  ByteSource source(data + 1, size - 1);
  const std::string content = data[0] < kMade ? source.text(size) : kWriters[format](&source);
  file.write(content.data(), content.size());
  try {
    const SourceMesh mesh = readFile(file.path());
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
