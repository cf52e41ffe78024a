// Stands in for TBB in a build with ThreadSanitizer: Debian's TBB is not built with it, so what TBB
// hands from thread to thread would look like races of ours, and nothing of ours could be told from
// them. The calls that this package makes, with TBB's names and meaning, on std::thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace tbb {

// More than a small machine has cores: races need threads.
constexpr int kDefaultThreads = 4;

// Returns the number of threads of a loop that this thread starts.
inline int& threadsHere() {
  thread_local int threads = kDefaultThreads;
  return threads;
}

// Runs all at the same time, the last one here; throws what one of them threw, after all have
// ended.
inline void runTogether(const std::vector<std::function<void()>>& tasks) {
  std::mutex mutex;
  std::exception_ptr thrown;
  const int limit = threadsHere();
  const auto guarded = [&](const std::function<void()>& task) {
    threadsHere() = limit;
    try {
      task();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      thrown = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(tasks.size());
  for (std::size_t i = 0; i + 1 < tasks.size(); ++i) threads.emplace_back(guarded, tasks[i]);
  guarded(tasks.back());
  for (std::thread& thread : threads) thread.join();
  if (thrown) std::rethrow_exception(thrown);
}

template <class First, class Second>
void parallel_invoke(const First& first, const Second& second) {
  if (threadsHere() > 1) {
    runTogether({first, second});
  } else {
    first();
    second();
  }
}

template <class Body>
void parallel_for(std::size_t begin, std::size_t end, const Body& body) {
  if (begin >= end) return;
  std::atomic<std::size_t> next{begin};
  const auto take = [&] {
    for (std::size_t i = next++; i < end; i = next++) body(i);
  };
  const auto threads = std::min(end - begin, static_cast<std::size_t>(threadsHere()));
  runTogether(std::vector<std::function<void()>>(threads, take));
}

class task_group {
 public:
  ~task_group() {
    if (thread_.joinable()) thread_.join();
  }

  // One at a time.
  template <class Task>
  void run(const Task& task) {
    thread_ = std::thread([this, task, limit = threadsHere()] {
      threadsHere() = limit;
      try {
        task();
      } catch (...) {
        thrown_ = std::current_exception();
      }
    });
  }
  void wait() {
    if (thread_.joinable()) thread_.join();
    if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
  }

 private:
  std::thread thread_;
  std::exception_ptr thrown_;
};

class task_arena {
 public:
  static constexpr int automatic = -1;

  explicit task_arena(int threads) : threads_(threads > 0 ? threads : kDefaultThreads) {}

  template <class Task>
  void execute(const Task& task) {
    const Restored restored{threadsHere()};
    threadsHere() = threads_;
    task();
  }

 private:
  struct Restored {
    int before;
    ~Restored() { threadsHere() = before; }
  };

  int threads_;
};

namespace this_task_arena {
inline int max_concurrency() { return threadsHere(); }
}  // namespace this_task_arena

// Here nothing limits threads but the arena.
class global_control {
 public:
  enum parameter { max_allowed_parallelism };
  global_control(parameter /*what*/, std::size_t /*value*/) {}
};

}  // namespace tbb
