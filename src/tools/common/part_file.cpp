// A file that has its name only once it is whole.
#include "tools/common/part_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

namespace deformable_contact_monitor {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path) {
  throw std::system_error(errno, std::generic_category(), path + ": cannot be written");
}

}  // namespace

PartFile::PartFile(const std::string& path) : path_(path), part_(path) {
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status)) {
    if (!fs::is_regular_file(status)) return;
    if (access(path.c_str(), W_OK) != 0) fail(path);
    const fs::path target = fs::canonical(path, none);
    if (!none) path_ = target.string();
  }
  part_ = path_ + "." + std::to_string(getpid()) + ".part";
}

PartFile::~PartFile() {
  if (isPlain() && !finished_) std::remove(part_.c_str());
}

void PartFile::finish() {
  if (isPlain() && std::rename(part_.c_str(), path_.c_str()) != 0) fail(path_);
  finished_ = true;
}

}  // namespace deformable_contact_monitor
