// A file that has its name only once it is whole.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// It is written under another name beside its own, `writtenAs()`, and gets its own at the end;
// until then, what had that name before stays. If it never comes to that, the other one is removed.
// What is no plain file (a device, a pipe) is written to directly. A link to a file stays one.
class PartFile {
 public:
  // Throws std::system_error that names `path` if that is a file that may not be written.
  explicit PartFile(const std::string& path);
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;
  ~PartFile();

  const std::string& writtenAs() const { return part_; }
  bool isPlain() const { return part_ != path_; }

  // It is whole, and closed. Once. Throws std::system_error that names it.
  void finish();

 private:
  std::string path_;
  std::string part_;
  bool finished_ = false;
};

}  // namespace deformable_contact_monitor
