// Writes the progress line from a thread of its own.
#include "tools/common/progress.h"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "core/common/stopwatch.h"
#include "tools/common/formatted.h"

namespace deformable_contact_monitor {

using std::chrono::milliseconds;

std::string progressTimes(double elapsed_s, const WorkDone& work) {
  if (work.part <= work.first_part || work.part >= 1) return formatted(" (%.0f s)", elapsed_s);
  const double left_s = work.since_s * (1 - work.part) / (work.part - work.first_part);
  constexpr double kMinute_s = 60;
  const bool in_minutes = left_s > 2 * kMinute_s;
  return formatted(" (%.0f s, about %.0f %s left)", elapsed_s,
                   in_minutes ? left_s / kMinute_s : left_s, in_minutes ? "min" : "s");
}

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

void Progress::setDone(double part) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (!first_time_) {
    first_time_ = now;
    work_.first_part = part;
  }
  work_.part = part;
  work_.since_s = std::chrono::duration<double>(now - *first_time_).count();
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
    std::fprintf(stderr, on_terminal_ ? "\r%s%s\x1b[K" : "%s%s\n", what_.c_str(),
                 progressTimes(stopwatch.elapsedMs() / 1e3, work_).c_str());
    std::fflush(stderr);
    written = true;
    wait = period;
  }
  if (written && on_terminal_) std::fputs("\r\x1b[K", stderr);
}

}  // namespace deformable_contact_monitor
