// An input as a file, for what reads files.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// A file of this process, in memory where there is /dev/shm; removed at the end.
class ScratchFile {
 public:
  // `ending`: of its name, ".obj". Throws std::runtime_error if there is no room.
  explicit ScratchFile(const std::string& ending);
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile();

  // Replaces what it holds.
  void write(const void* data, std::size_t size) const;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

// Returns whether `error` begins with the file's path. Every message that rejects a file must.
bool namesFile(const std::string& error, const ScratchFile& file);

}  // namespace deformable_contact_monitor
