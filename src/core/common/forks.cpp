#include "core/common/forks.h"

#include <pthread.h>

namespace deformable_contact_monitor {
namespace {

std::atomic<unsigned> forks{0};

// The system calls this in each forked process, before fork() returns there.
void countFork() { forks.fetch_add(1, std::memory_order_relaxed); }

// Registers countFork() when the library is loaded.
const int is_registered = pthread_atfork(nullptr, nullptr, &countFork);

ProcessMark uses_threads;

}  // namespace

unsigned forkCount() {
  static_cast<void>(is_registered);
  return forks.load(std::memory_order_relaxed);
}

bool mayUseThreads() {
  if (uses_threads.isInherited()) return false;
  if (!uses_threads.isSet()) uses_threads.set();
  return true;
}

}  // namespace deformable_contact_monitor
