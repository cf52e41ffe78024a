// Says on standard error what long work is at.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace deformable_contact_monitor {

// On a terminal, one line that is rewritten and wiped at the end; elsewhere (a log), a line after
// two seconds and then every ten. Work that is done sooner says nothing. Any thread.
class Progress {
 public:
  explicit Progress(std::string what);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  // What the work is at from now on.
  void set(std::string what);

 private:
  void run();

  const bool on_terminal_;
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopped_ = false;
  std::string what_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace deformable_contact_monitor
