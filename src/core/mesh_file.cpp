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

using Reader = TriangleMesh (*)(const std::string& path, std::string_view content);

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

}  // namespace

bool isMeshFileName(const std::string& path) { return readerFor(path) != nullptr; }

TriangleMesh readMeshFile(const std::string& path) {
  const Reader read = readerFor(path);
  if (read == nullptr) {
    throw std::runtime_error(path + ": cannot tell the format from the name; mesh files end in " +
                             ".obj, .off, .ply or .stl");
  }
  try {
    const std::string content = readWhole(path);
    if (content.empty()) throw std::runtime_error(path + ": is empty");
    TriangleMesh mesh = read(path, content);
    if (mesh.triangles.empty()) throw std::runtime_error(path + ": holds no triangle");
    validate(mesh, path);
    return mesh;
  } catch (const std::invalid_argument& refused) {
    throw std::runtime_error(refused.what());
  } catch (const std::bad_alloc&) {
    throw std::runtime_error(path + ": is too large for this machine's memory");
  }
}

}  // namespace deformable_contact_monitor
