// Mesh files of robot links. They are foreign, and so is the library that reads them: each is read
// by a process of its own.
#include "robot/link_mesh_file.h"

#include <algorithm>

#include "robot/mesh_stream.h"
#include "robot/reader_process.h"
#include "robot/reader_program.h"

namespace deformable_contact_monitor {
namespace {

// Sizes are looked at before anything is allocated for them.
MeshStreamHeader readHeader(ReaderProcess& reader) {
  MeshStreamHeader header;
  reader.read(&header, sizeof(header));
  if (header.start != kMeshStreamStart) {
    throw std::runtime_error("its reader's answer is none: is it of another version?");
  }
  if (header.refusal_bytes > kMaxRefusalBytes ||
      !fitsMeshLimit(header.vertices, header.triangles, kMaxMeshMib * kBytesPerMib)) {
    throw std::runtime_error("more than " + std::to_string(kMaxMeshMib) +
                             " MiB of vertices and triangles");
  }
  return header;
}

SourceMesh readMesh(ReaderProcess& reader) {
  const MeshStreamHeader header = readHeader(reader);
  if (header.refusal_bytes > 0) {
    std::string refusal(header.refusal_bytes, '\0');
    reader.read(refusal.data(), refusal.size());
    throw std::runtime_error(refusal);
  }
  SourceMesh mesh;
  mesh.vertices.resize(header.vertices);
  reader.read(mesh.vertices.data(), mesh.vertices.size() * sizeof(StreamVertex));
  mesh.triangles.resize(header.triangles);
  reader.read(mesh.triangles.data(), mesh.triangles.size() * sizeof(StreamTriangle));
  for (const StreamTriangle& triangle : mesh.triangles) {
    if (*std::max_element(triangle.begin(), triangle.end()) >= header.vertices) {
      throw std::runtime_error("its reader's answer has a vertex index out of range");
    }
  }
  return mesh;
}

}  // namespace

SourceMesh readLinkMeshFile(const std::string& path, const MeshReading& reading) {
  try {
    ReaderProcess reader(reading.program.empty() ? findReaderProgram() : reading.program, path,
                         reading.file_time, reading.stop);
    return readMesh(reader);
  } catch (const ReadingStopped&) {
    throw;
  } catch (const std::exception& e) {
    throw std::runtime_error(path + ": " + e.what());
  }
}

}  // namespace deformable_contact_monitor
