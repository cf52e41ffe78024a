// A file, or standard output, that is written at once, with its errors.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace deformable_contact_monitor {

class OutputFile {
 public:
  // Opens and empties the file; "-" is standard output. Throws std::system_error that names it.
  explicit OutputFile(const std::string& path);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  // Once. All of it is with the system when this returns. Throws std::system_error that names the
  // file; a reader that went away is std::errc::broken_pipe (with SIGPIPE ignored).
  void write(std::string_view text);

 private:
  std::string name_;
  std::FILE* file_;
};

// With the folders above it, where they are missing. Throws std::system_error that names it.
void makeFolder(const std::string& folder);

// A forgotten file name, as in "--pairs a.obj b.obj", must not cost a mesh. Throws
// std::invalid_argument, one line, if the file's name is a mesh's.
void refuseMeshAsOutput(const std::string& option, const std::string& file);

}  // namespace deformable_contact_monitor
