// A file, or standard output, that is written at once, with its errors.
#include "tools/common/output_file.h"

#include <cerrno>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "core/mesh_file.h"
#include "tools/common/part_file.h"

namespace deformable_contact_monitor {

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path == "-") {
    stream_ = stdout;
    return;
  }
  const PartFile part(path);
  std::FILE* const opened = open(part.writtenAs());
  if (part.isPlain()) {
    std::fclose(opened);
  } else {
    stream_ = opened;
  }
}

OutputFile::~OutputFile() {
  if (stream_ != nullptr && stream_ != stdout) std::fclose(stream_);
}

void OutputFile::write(std::string_view text) {
  if (stream_ != nullptr) return writeTo(stream_, text);
  PartFile part(path_);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open(part.writtenAs()), std::fclose);
  writeTo(file.get(), text);
  part.finish();
}

std::FILE* OutputFile::open(const std::string& path) const {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) fail();
  return file;
}

void OutputFile::writeTo(std::FILE* file, std::string_view text) const {
  if (std::fwrite(text.data(), 1, text.size(), file) != text.size() || std::fflush(file) != 0) {
    fail();
  }
}

void OutputFile::fail() const {
  throw std::system_error(errno, std::generic_category(),
                          (path_ == "-" ? "standard output" : path_) + ": cannot be written");
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
