// Shows on standard error what a long computation is doing.
//
// Computations that finish quickly write nothing, so scripts see only results and errors.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace deformable_contact_monitor {

// Rewrites one line on a terminal, and removes it at the end. In a log file, writes a line after
// two seconds, and then every ten seconds. Short computations show nothing. Functions may be called
// from any thread.
class Progress {
 public:
  explicit Progress(std::string what);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  // Sets the text that is shown from now on.
  void set(std::string what);

 private:
  // Runs in the class's own thread until the destructor.
  void run();

  const bool on_terminal_;
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopped_ = false;
  std::string what_;
  std::thread thread_;  // uses the other members, so it comes last
};

}  // namespace deformable_contact_monitor
