// What the parent of read_link_mesh makes of any answer: a process writes the input to its standard
// output, and ends.
#include <stdexcept>

#include "fuzz_target.h"
#include "robot/link_mesh_file.h"
#include "scratch_file.h"

namespace deformable_contact_monitor {
namespace {

// Past the first check: the answer is a mesh.
bool tryLinkAnswer(const std::uint8_t* data, std::size_t size) {
  static const ScratchFile file(".answer");
  file.write(data, size);
  MeshReading reading;
  reading.program = "/bin/cat";
  try {
    const SourceMesh mesh = readLinkMeshFile(file.path(), reading);
    LinkMeshBuilder builder;
    builder.append(mesh, Eigen::Affine3d::Identity());
    validate(builder.mesh(), "a link's mesh");
    requireThat(builder.mesh().triangleCount() == mesh.triangles.size(), "triangles were lost");
    return true;
  } catch (const std::runtime_error& refusal) {
    requireThat(namesFile(refusal.what(), file), "a refusal does not name its file");
    return false;
  }
}

const FuzzTargetEntry entry("link_answer", tryLinkAnswer);

}  // namespace
}  // namespace deformable_contact_monitor
