// Tells whether something is from before a fork. A forked process has none of the threads of the
// process that it was forked from, and cannot use its CUDA devices. Whoever waits for those there
// waits for ever.
#pragma once

#include <atomic>

#include "core/export.h"

namespace deformable_contact_monitor {

// Returns how many forks led to this process since it, or the process that it was forked from,
// loaded this library. Any thread may call it.
DCM_EXPORT unsigned forkCount();

// Remembers the process that set it. Any thread may call its functions.
class ProcessMark {
 public:
  void set() { process_.store(forkCount() + 1, std::memory_order_relaxed); }
  void clear() { process_.store(0, std::memory_order_relaxed); }

  bool isSet() const { return process_.load(std::memory_order_relaxed) != 0; }
  // Returns whether it was set before a fork that led to this process, and not cleared since.
  bool isInherited() const {
    const unsigned process = process_.load(std::memory_order_relaxed);
    return process != 0 && process != forkCount() + 1;
  }

 private:
  std::atomic<unsigned> process_{0};  // forkCount() + 1; 0: it is not set
};

// Returns whether this process may run work on TBB's threads. It may not if it was forked after
// this library had used them: TBB would wait for threads and locks that are gone.
DCM_EXPORT bool mayUseThreads();

}  // namespace deformable_contact_monitor
