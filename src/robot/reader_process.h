// A running read_link_mesh.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace deformable_contact_monitor {

// Started by exec, since a bare fork of a process with threads and a GPU can do little that is
// safe. In a process group of its own: Ctrl-C in a terminal is for whoever started it. What goes
// wrong with it is said as a std::runtime_error whose text fits behind the file's name.
class ReaderProcess {
 public:
  // Throws if the program cannot be started. `stop` may be empty.
  ReaderProcess(const std::string& program, const std::string& mesh_file,
                std::chrono::milliseconds max_time, std::function<bool()> stop);
  ReaderProcess(const ReaderProcess&) = delete;
  ReaderProcess& operator=(const ReaderProcess&) = delete;
  // Ends the process, whatever it does.
  ~ReaderProcess();

  // Waits until the process has written so many bytes. Throws if it ends before, or if max_time
  // since its start has passed; throws ReadingStopped.
  void read(void* to, std::size_t bytes);

 private:
  using Clock = std::chrono::steady_clock;

  void start(const std::string& program, const std::string& mesh_file, int its_output);
  void waitForOutput() const;
  [[noreturn]] void throwHowItEnded();
  std::optional<int> exitStatus();

  const std::chrono::milliseconds max_time_;
  const Clock::time_point deadline_;
  const std::function<bool()> stop_;
  pid_t process_ = 0;  // 0: none, or its exit status was had
  int output_ = -1;
};

}  // namespace deformable_contact_monitor
