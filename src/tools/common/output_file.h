// Files that the tools write. A file gets its name only once it is complete, so a reader never
// finds half a file, and an error leaves an earlier file as it was.
#pragma once

#include <cstdio>
#include <fstream>
#include <string>
#include <string_view>

namespace deformable_contact_monitor {

// Owns the temporary name of a file until the file is complete. Write to writtenAs(), close it, and
// call finish(), which renames it; the destructor removes an unfinished file, and so do SIGINT,
// SIGTERM and SIGHUP where they end the process. What is not a plain file (a device, a pipe) is
// written to directly. A symbolic link to a file stays a link.
class AtomicFile {
 public:
  // Throws std::system_error that names `path` if that file exists and may not be written.
  explicit AtomicFile(const std::string& path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  // Returns the name to write to: the temporary one, or the path itself if it is no plain file.
  const std::string& writtenAs() const { return temporary_; }
  // Returns whether finish() renames a temporary file.
  bool isPlain() const { return temporary_ != path_; }

  // Gives the closed file its name. Call it once. Throws std::system_error that names the file.
  void finish();

 private:
  std::string path_;
  std::string temporary_;
  bool finished_ = false;
};

// A file, or standard output, that is written in one piece.
class OutputFile {
 public:
  // `path` "-" is standard output. Checks that the file can be written, so that a long computation
  // does not fail at its end, but does not change it. Throws std::system_error that names it.
  explicit OutputFile(const std::string& path);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  // Writes and flushes everything. Call it once. Throws std::system_error that names the file,
  // which is then unchanged. If the reader of a pipe has gone, the error is std::errc::broken_pipe;
  // SIGPIPE must be ignored for that.
  void write(std::string_view text);

 private:
  [[noreturn]] void fail() const;
  std::FILE* open(const std::string& path) const;
  void writeTo(std::FILE* file, std::string_view text) const;

  std::string path_;
  std::FILE* stream_ = nullptr;  // of standard output or of what is not a plain file; else null
};

// A file that is written line by line while something is computed. The functions throw
// std::system_error that names the file.
class TableFile {
 public:
  explicit TableFile(const std::string& path);
  // Writes the text and a line end.
  void line(const std::string& text);
  // Flushes everything and gives the file its name. Call it once, after the last line.
  void finish();

 private:
  [[noreturn]] void fail() const;

  std::string path_;
  AtomicFile atomic_;
  std::ofstream file_;
};

// Makes the folder and its missing parents. Throws std::system_error that names it.
void makeFolder(const std::string& folder);

// Throws std::invalid_argument, one line, if `file` has a mesh's ending. This protects meshes from
// a forgotten file name, as in "--pairs a.obj b.obj".
void refuseMeshAsOutput(const std::string& option, const std::string& file);

}  // namespace deformable_contact_monitor
