// Loops on threads. Blocks are a function of the range alone, so results do not depend on how many
// threads there are.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <optional>
#include <thread>

#include "core/common/cycle_limit.h"

namespace deformable_contact_monitor {

// Where what several threads write lies side by side, each thread's is aligned to this: processors
// hand cache lines to one another in pairs.
constexpr std::size_t kOwnLines = 128;

inline std::size_t blockCount(std::size_t n, std::size_t block_size) {
  return (n + block_size - 1) / block_size;
}

// body(block, begin, end) for each block of [0, n).
template <class Body>
void parallelBlocks(std::size_t n, std::size_t block_size, const Body& body) {
  tbb::parallel_for(std::size_t{0}, blockCount(n, block_size), [&](std::size_t block) {
    body(block, block * block_size, std::min(n, (block + 1) * block_size));
  });
}

// As above, but once the limit is over, blocks that did not begin are left out.
template <class Body>
void parallelBlocks(const CycleLimit& limit, std::size_t n, std::size_t block_size,
                    const Body& body) {
  parallelBlocks(n, block_size, [&](std::size_t block, std::size_t begin, std::size_t end) {
    if (!limit.over()) body(block, begin, end);
  });
}

// body(begin, end) for each block of [0, n), by this thread and in order, until the limit is over.
template <class Body>
void serialBlocks(const CycleLimit& limit, std::size_t n, std::size_t block_size,
                  const Body& body) {
  for (std::size_t begin = 0; begin < n && !limit.over(); begin += block_size) {
    body(begin, std::min(n, begin + block_size));
  }
}

// What another thread does meanwhile, if there is one for it.
class BesideTask {
 public:
  template <class Work>
  void start(const Work& work) {
    group_.emplace().run(work);
  }
  // For the end of what was started, if anything was, and throws what that threw. To be called
  // before this goes.
  void wait() {
    if (group_) group_->wait();
  }

 private:
  std::optional<tbb::task_group> group_;
};

// A thread that is awake for as long as this lives, a millisecond at most, if there is one for it.
// For who waits for a device, and then goes on in parallel: a thread takes its time to get up, but
// one that is up soon has the others up.
class AwakeThread {
 public:
  AwakeThread() {
    thread_.run([this] {
      constexpr std::chrono::milliseconds kMost(1);
      const auto end = std::chrono::steady_clock::now() + kMost;
      while (is_wanted_ && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    });
  }
  AwakeThread(const AwakeThread&) = delete;
  AwakeThread& operator=(const AwakeThread&) = delete;
  ~AwakeThread() {
    is_wanted_ = false;
    thread_.wait();
  }

 private:
  std::atomic<bool> is_wanted_{true};
  tbb::task_group thread_;
};

// Both, at the same time if there are threads for it.
template <class First, class Second>
void parallelBoth(const First& first, const Second& second) {
  tbb::parallel_invoke(first, second);
}

}  // namespace deformable_contact_monitor
