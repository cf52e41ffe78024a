// The program read_link_mesh: where it is installed, and one running instance of it.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace deformable_contact_monitor {

// Returns the path of read_link_mesh: beside the program or shared library that this code is part
// of, in the package's folder of programs next to that library, or in a workspace of
// CMAKE_PREFIX_PATH. So it belongs to the same build in the devel space, in an install space and in
// a plain build folder, also for a nodelet in another package's process. Throws std::runtime_error
// with the places where it was looked for.
std::string findReaderProgram();

// A process that reads one mesh file and writes the mesh to a pipe (mesh_stream.h).
//
// It is started by exec, because a process with threads and a GPU context can do little that is
// safe after a bare fork. It has a process group of its own, so that Ctrl-C in a terminal reaches
// only the program that the user started. Errors are std::runtime_error, with a text that reads
// well after the file's name.
class ReaderProcess {
 public:
  // Throws if the program cannot be started. `stop` may be empty.
  ReaderProcess(const std::string& program, const std::string& mesh_file,
                std::chrono::milliseconds max_time, std::function<bool()> stop);
  ReaderProcess(const ReaderProcess&) = delete;
  ReaderProcess& operator=(const ReaderProcess&) = delete;
  // Ends the process, whatever it does.
  ~ReaderProcess();

  // Waits until the process has written `bytes` bytes and copies them to `to`. Throws if the
  // process ends before, or if max_time has passed since its start; throws ReadingStopped.
  void read(void* to, std::size_t bytes);

 private:
  using Clock = std::chrono::steady_clock;

  // Starts the process with its standard output connected to `its_output`.
  void start(const std::string& program, const std::string& mesh_file, int its_output);
  // Waits until there are bytes to read or the output has ended. Throws like read().
  void waitForOutput() const;
  // Throws an error that says why the process ended without a full answer.
  [[noreturn]] void throwHowItEnded();
  std::optional<int> exitStatus();

  const std::chrono::milliseconds max_time_;
  const Clock::time_point deadline_;
  const std::function<bool()> stop_;
  pid_t process_ = 0;  // 0: not running, or its exit status was read
  int output_ = -1;
};

}  // namespace deformable_contact_monitor
