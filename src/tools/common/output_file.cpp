// A file, or standard output, that is written at once, with its errors.
#include "tools/common/output_file.h"

#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "core/mesh_files/mesh_file.h"

namespace deformable_contact_monitor {
namespace {

[[noreturn]] void fail(const std::string& name) {
  throw std::system_error(errno, std::generic_category(), name + ": cannot be written");
}

}  // namespace

OutputFile::OutputFile(const std::string& path)
    : name_(path == "-" ? "standard output" : path),
      file_(path == "-" ? stdout : std::fopen(path.c_str(), "wb")) {
  if (file_ == nullptr) fail(name_);
}

OutputFile::~OutputFile() {
  if (file_ != stdout) std::fclose(file_);
}

void OutputFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size() || std::fflush(file_) != 0) {
    fail(name_);
  }
}

void makeFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::system_error(error, folder + ": cannot be made");
}

void refuseMeshAsOutput(const std::string& option, const std::string& file) {
  if (!isMeshFileName(file)) return;
  throw std::invalid_argument(option + ": would write over the mesh file " + file +
                              "; it takes a file to write or - (see --help)");
}

}  // namespace deformable_contact_monitor
