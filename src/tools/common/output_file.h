// A file, or standard output, that is written at once, with its errors.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace deformable_contact_monitor {

class OutputFile {
 public:
  // "-" is standard output. Sees that the file can be written, so that what takes long is not in
  // vain, but leaves it as it is. Throws std::system_error that names it.
  explicit OutputFile(const std::string& path);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  // Once. All of it is with the system when this returns; a file is replaced as a whole, or, where
  // this throws, not at all. Throws std::system_error that names the file; a reader that went away
  // is std::errc::broken_pipe (with SIGPIPE ignored).
  void write(std::string_view text);

 private:
  [[noreturn]] void fail() const;
  std::FILE* open(const std::string& path) const;
  void writeTo(std::FILE* file, std::string_view text) const;

  std::string path_;
  std::FILE* stream_ = nullptr;  // of what is no plain file; else null
};

// With the folders above it, where they are missing. Throws std::system_error that names it.
void makeFolder(const std::string& folder);

// A forgotten file name, as in "--pairs a.obj b.obj", must not cost a mesh. Throws
// std::invalid_argument, one line, if the file's name is a mesh's.
void refuseMeshAsOutput(const std::string& option, const std::string& file);

}  // namespace deformable_contact_monitor
