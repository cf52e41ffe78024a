// The format in which read_link_mesh writes to its standard output: a header, then either the
// vertices (three doubles each), triangles (three std::uint32_t each) and a note, or the text that
// says why the file was rejected. The byte order is this machine's, since both ends are of one
// build.
#pragma once

#include <cstdint>

#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

// Tells this format and its version, in case another program is found under the reader's name.
constexpr std::uint64_t kMeshStreamStart = 0x326873656d6d6364;  // "dcmmesh2"

// Begins every answer. It has no padding, so it is written and read as it is in memory.
struct MeshStreamHeader {
  std::uint64_t start = kMeshStreamStart;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t note_bytes = 0;     // the length of SourceMesh::note
  std::uint64_t refusal_bytes = 0;  // 0: a mesh follows; else the length of the text
};
static_assert(sizeof(MeshStreamHeader) == 40, "no padding");

using StreamVertex = Eigen::Vector3d;
using StreamTriangle = std::array<std::uint32_t, 3>;
static_assert(sizeof(StreamVertex) == 24 && sizeof(StreamTriangle) == 12, "no padding");

// Returns whether a mesh of this size takes at most max_bytes, without overflow.
constexpr bool fitsMeshLimit(std::uint64_t vertices, std::uint64_t triangles,
                             std::uint64_t max_bytes) {
  return vertices <= max_bytes / sizeof(StreamVertex) &&
         triangles <= (max_bytes - vertices * sizeof(StreamVertex)) / sizeof(StreamTriangle);
}

}  // namespace deformable_contact_monitor
