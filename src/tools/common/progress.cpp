// Writes the progress line from a thread of its own.
#include "tools/common/progress.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <utility>

#include "core/common/stopwatch.h"

namespace deformable_contact_monitor {

using std::chrono::milliseconds;

Progress::Progress(std::string what)
    : on_terminal_(isatty(STDERR_FILENO) != 0),
      what_(std::move(what)),
      thread_([this] { run(); }) {}

Progress::~Progress() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = true;
  }
  stop_.notify_one();
  thread_.join();
}

void Progress::set(std::string what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  what_ = std::move(what);
}

void Progress::run() {
  const Stopwatch stopwatch;
  const auto stopped = [this] { return stopped_; };
  const milliseconds period(on_terminal_ ? 200 : 10000);
  milliseconds wait(on_terminal_ ? 500 : 2000);
  bool written = false;
  std::unique_lock<std::mutex> lock(mutex_);
  // Writes the line again and again until the destructor wakes this thread.
  while (!stop_.wait_for(lock, wait, stopped)) {
    std::fprintf(stderr, on_terminal_ ? "\r%s (%.0f s)\x1b[K" : "%s (%.0f s)\n", what_.c_str(),
                 stopwatch.elapsedMs() / 1e3);
    std::fflush(stderr);
    written = true;
    wait = period;
  }
  if (written && on_terminal_) std::fputs("\r\x1b[K", stderr);
}

}  // namespace deformable_contact_monitor
