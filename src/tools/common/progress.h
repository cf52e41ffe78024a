// Shows on standard error what a long computation is doing.
//
// Computations that finish quickly write nothing, so scripts see only results and errors.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace deformable_contact_monitor {

// How far some work has come.
struct WorkDone {
  double since_s = 0;               // time since the first part was done [s]
  double first_part = 0, part = 0;  // of the work, in [0, 1]: then, and now
};

// Returns the end of a line of progress: how long all has taken [s], and how much time is left if
// the rest goes on as since the first part. The latter is left out once all of the work is done.
std::string progressTimes(double elapsed_s, const WorkDone& work);

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

  // Sets which part of the work is done, in [0, 1]. From the second call on, the line says how much
  // time is left if the rest goes on as since the first call.
  void setDone(double part);

 private:
  // Runs in the class's own thread until the destructor.
  void run();
  const bool on_terminal_;
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopped_ = false;
  std::string what_;
  std::optional<std::chrono::steady_clock::time_point> first_time_;  // of setDone(); nothing: none
  WorkDone work_;
  std::thread thread_;  // uses the other members, so it comes last
};

}  // namespace deformable_contact_monitor
