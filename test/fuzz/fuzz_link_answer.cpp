// Feeds arbitrary answers to the parent process of read_link_mesh. A child process writes the
// answer to its standard output and ends. If the first byte is even, the answer is the other bytes.
// If it is odd, the answer is a header that fits, then vertices and triangles made of the other
// bytes, seldom cut off.
#include <stdexcept>
#include <string>

#include "byte_source.h"
#include "fuzz_target.h"
#include "robot/link_mesh_files.h"
#include "robot/mesh_stream.h"
#include "scratch_file.h"
#include "text_writer.h"

namespace deformable_contact_monitor {
namespace {

std::string meshAnswer(ByteSource* source) {
  constexpr std::size_t kMost = 16;
  MeshStreamHeader header;
  header.vertices = source->below(kMost);
  header.triangles = source->below(kMost);
  const bool is_cut_off = source->below(kMost) == 0;
  std::string answer(reinterpret_cast<const char*>(&header), sizeof header);
  for (std::size_t i = 0; i < 3 * header.vertices; ++i) {
    const double coordinate = source->flag() ? source->number<double>() : source->coordinate();
    answer.append(reinterpret_cast<const char*>(&coordinate), sizeof coordinate);
  }
  for (std::size_t i = 0; i < 3 * header.triangles; ++i) {
    const auto index = static_cast<std::uint32_t>(indexFrom(source, header.vertices));
    answer.append(reinterpret_cast<const char*>(&index), sizeof index);
  }
  if (is_cut_off) answer.resize(answer.size() - 1);
  return answer;
}

// Past the first check: the answer is a mesh.
bool tryLinkAnswer(const std::uint8_t* data, std::size_t size) {
  static const ScratchFile file(".answer");
  ByteSource source(data, size);
  const std::string answer = source.flag() ? meshAnswer(&source) : source.text(size);
  file.write(answer.data(), answer.size());
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
