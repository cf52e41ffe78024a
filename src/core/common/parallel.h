// Loops on the threads of the current TBB arena. How a range is divided into blocks depends on the
// range alone, so results do not depend on the number of threads. In a process that was forked from
// one that had used TBB's threads, everything runs on the calling thread.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>

#include "core/common/cycle_limit.h"
#include "core/common/forks.h"

namespace deformable_contact_monitor {

// The alignment of data that different threads write, if it is stored side by side [bytes].
// Processors move cache lines between cores in pairs, so it is two lines.
constexpr std::size_t kOwnLines = 128;

// Returns how many blocks of that size a range of n elements has; the last may be shorter.
inline std::size_t blockCount(std::size_t n, std::size_t block_size) {
  return (n + block_size - 1) / block_size;
}

// Calls body(block, begin, end) for each block of [0, n), in parallel.
template <class Body>
void parallelBlocks(std::size_t n, std::size_t block_size, const Body& body) {
  const auto runBlock = [&](std::size_t block) {
    body(block, block * block_size, std::min(n, (block + 1) * block_size));
  };
  const std::size_t count = blockCount(n, block_size);
  if (mayUseThreads()) {
    tbb::parallel_for(std::size_t{0}, count, runBlock);
  } else {
    for (std::size_t block = 0; block < count; ++block) runBlock(block);
  }
}

// Does the same, but skips blocks that have not begun when the limit is over.
template <class Body>
void parallelBlocks(const CycleLimit& limit, std::size_t n, std::size_t block_size,
                    const Body& body) {
  parallelBlocks(n, block_size, [&](std::size_t block, std::size_t begin, std::size_t end) {
    if (!limit.over()) body(block, begin, end);
  });
}

// Calls body(begin, end) for each block of [0, n) in order, on this thread, until the limit is
// over.
template <class Body>
void serialBlocks(const CycleLimit& limit, std::size_t n, std::size_t block_size,
                  const Body& body) {
  for (std::size_t begin = 0; begin < n && !limit.over(); begin += block_size) {
    body(begin, std::min(n, begin + block_size));
  }
}

// A task that runs on another thread, if one is free, while this thread does other work.
class BesideTask {
 public:
  template <class Work>
  void start(const Work& work) {
    if (mayUseThreads()) {
      group_.emplace().run(work);
    } else {
      work();
    }
  }
  // Waits until the task has ended, if one was started. Throws what the task threw. Must be called
  // before the object is destroyed.
  void wait() {
    if (group_) group_->wait();
  }

 private:
  std::optional<tbb::task_group> group_;
};

// Calls both functions, at the same time if a thread is free.
template <class First, class Second>
void parallelBoth(const First& first, const Second& second) {
  if (mayUseThreads()) {
    tbb::parallel_invoke(first, second);
  } else {
    first();
    second();
  }
}

// Returns how many threads work at most on a loop that is begun here.
inline std::size_t threadCount() {
  if (!mayUseThreads()) return 1;
  return static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
}

// The threads of one detector. They are kept as long as their number stays the same, because
// starting them takes time. For one thread at a time.
class Threads {
 public:
  Threads() = default;
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;
  ~Threads() {
    if (made_.isInherited()) static_cast<void>(arena_.release());
  }

  // Calls work(), whose loops run on `threads` threads; 0: on one per core.
  template <class Work>
  void run(int threads, const Work& work) {
    if (!mayUseThreads()) {
      work();
      return;
    }
    if (arena_ == nullptr || threads_ != threads) {
      arena_ = std::make_unique<tbb::task_arena>(threads > 0 ? threads
                                                             : int{tbb::task_arena::automatic});
      threads_ = threads;
      made_.set();
    }
    arena_->execute(work);
  }

 private:
  std::unique_ptr<tbb::task_arena> arena_;
  int threads_ = 0;
  ProcessMark made_;  // set with arena_
};

}  // namespace deformable_contact_monitor
