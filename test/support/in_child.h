// Runs a part of a test in a forked process.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <iterator>
#include <thread>

namespace deformable_contact_monitor {

// Waits until no thread of this process has started or ended for a tenth of a second. With
// AddressSanitizer (of GCC 12, at least) a child hangs when it starts a thread, if another thread
// was starting or ending at the fork: its list of threads is locked there. TBB starts one for each
// core.
inline void awaitQuietThreads() {
  constexpr int kQuietPolls = 10, kMostPolls = 500;
  std::ptrdiff_t count = 0;
  for (int poll = 0, quiet = 0; poll < kMostPolls && quiet < kQuietPolls; ++poll) {
    const std::filesystem::directory_iterator threads("/proc/self/task");
    const std::ptrdiff_t now = std::distance(begin(threads), end(threads));
    quiet = now == count ? quiet + 1 : 0;
    count = now;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

// Runs `work` in a forked process. Returns its exit code: 0 if `work` returned true, and minus the
// signal that ended it, which is SIGALRM if it hung.
inline int inChild(const std::function<bool()>& work) {
  constexpr unsigned kPatience_s = 60;
  constexpr int kWrong = 3;
#ifdef __SANITIZE_ADDRESS__
  awaitQuietThreads();
#endif
  const pid_t child = fork();
  if (child == 0) {
    alarm(kPatience_s);
    _exit(work() ? 0 : kWrong);
  }
  int status = 0;
  EXPECT_EQ(child, waitpid(child, &status, 0));
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace deformable_contact_monitor
