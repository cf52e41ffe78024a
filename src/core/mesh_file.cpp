// Chooses the reader by the file's name, and rejects files that no reader should get.
#include "core/mesh_file.h"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <new>
#include <stdexcept>
#include <system_error>

#include "core/mesh_files/mesh_readers.h"
#include "core/mesh_files/mesh_text.h"

namespace deformable_contact_monitor {
namespace {

using Reader = TriangleMesh (*)(const std::string& path, std::string_view content,
                                MeshFileReport* report, MeshGroups* groups);

// Returns the reader for the file name's ending; null if there is none.
Reader readerFor(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (equalIgnoringCase(ending, ".obj")) return readObj;
  if (equalIgnoringCase(ending, ".off")) return readOff;
  if (equalIgnoringCase(ending, ".ply")) return readPly;
  if (equalIgnoringCase(ending, ".stl")) return readStl;
  return nullptr;
}

std::string readWhole(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (error) throw std::runtime_error(path + ": " + error.message());
  // A pipe or a device could make the reader wait for ever, so only regular files are read.
  if (!std::filesystem::is_regular_file(status)) {
    throw std::runtime_error(path + (std::filesystem::is_directory(status)
                                         ? ": is a directory, not a mesh file"
                                         : ": is not a regular file"));
  }
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) {
    throw std::runtime_error(path + ": " +
                             std::error_code(errno, std::generic_category()).message());
  }
  std::string content(size, '\0');
  file.read(content.data(), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(file.gcount()) != size) {
    throw std::runtime_error(path + ": could not be read to its end");
  }
  return content;
}

TriangleMesh readFile(const std::string& path, MeshFileReport* report, MeshGroups* groups) {
  try {
    // A name that tells no format is rejected before a large file is read.
    return readMeshContent(path, isMeshFileName(path) ? readWhole(path) : std::string(), report,
                           groups);
  } catch (const std::bad_alloc&) {
    throw std::runtime_error(path + ": is too large for this machine's memory");
  }
}

}  // namespace

bool isMeshFileName(const std::string& path) { return readerFor(path) != nullptr; }

TriangleMesh readMeshContent(const std::string& path, std::string_view content,
                             MeshFileReport* report, MeshGroups* groups) {
  const Reader read = readerFor(path);
  if (read == nullptr) {
    throw std::runtime_error(path + ": cannot tell the format from the name; mesh files end in " +
                             ".obj, .off, .ply or .stl");
  }
  *report = MeshFileReport();
  try {
    TriangleMesh mesh = read(path, content, report, groups);
    if (mesh.triangles.empty()) throw std::runtime_error(path + ": holds no triangle");
    validate(mesh, path);
    if (report->fans.empty()) report->fans = mesh.triangles;
    return mesh;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& refused) {
    const std::string reason = unreadableBecause(content);
    throw std::runtime_error(reason.empty() ? refused.what() : path + ": " + reason);
  }
}

TriangleMesh readMeshFile(const std::string& path, MeshFileReport* report) {
  MeshFileReport unused;
  return readFile(path, report == nullptr ? &unused : report, nullptr);
}

TriangleMesh readMeshGroups(const std::string& path, const std::vector<std::string>& names,
                            std::vector<TriangleRanges>* triangles) {
  MeshGroups groups(names);
  MeshFileReport unused;
  TriangleMesh mesh = readFile(path, &unused, &groups);
  groups.requireAll(path);
  triangles->clear();
  for (const std::string& name : names) triangles->push_back(groups.wanted().at(name).triangles);
  return mesh;
}

}  // namespace deformable_contact_monitor
