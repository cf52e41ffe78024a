// Runs a part of a test in a forked process.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

namespace deformable_contact_monitor {

// Runs `work` in a forked process. Returns its exit code: 0 if `work` returned true, and minus the
// signal that ended it, which is SIGALRM if it hung.
inline int inChild(const std::function<bool()>& work) {
  constexpr unsigned kPatience_s = 60;
  constexpr int kWrong = 3;
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
