#include "scratch_file.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace deformable_contact_monitor {

ScratchFile::ScratchFile(const std::string& ending) {
  const std::filesystem::path memory = "/dev/shm";
  const std::filesystem::path folder =
      std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
  path_ = (folder / ("dcm_fuzz_" + std::to_string(getpid()) + ending)).string();
}

ScratchFile::~ScratchFile() { unlink(path_.c_str()); }

void ScratchFile::write(const void* data, std::size_t size) const {
  std::ofstream file(path_, std::ios::binary | std::ios::trunc);
  file.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  if (!file.flush()) throw std::runtime_error(path_ + ": cannot be written");
}

bool namesFile(const std::string& error, const ScratchFile& file) {
  return error.compare(0, file.path().size(), file.path()) == 0;
}

}  // namespace deformable_contact_monitor
