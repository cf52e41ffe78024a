// A thread that is kept awake: it takes no thread from anybody for long, and wants none.
#include "core/common/parallel.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <thread>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

// Whether both came here, before one gave up.
class Rendezvous {
 public:
  bool meet() {
    constexpr std::chrono::seconds kLong(20);
    const auto end = Clock::now() + kLong;
    ++here_;
    while (here_ < 2 && Clock::now() < end) std::this_thread::yield();
    return here_ == 2;
  }

 private:
  std::atomic<int> here_{0};
};

TEST(AwakeThread, LeavesItsThreadToWhoNeedsIt) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "takes two processors";
  tbb::task_arena two(2);
  two.execute([] {
    const AwakeThread awake;
    // As late as it is awake for sure, if it is at all.
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    Rendezvous rendezvous;
    bool first = false, second = false;
    parallelBoth([&] { first = rendezvous.meet(); }, [&] { second = rendezvous.meet(); });
    EXPECT_TRUE(first && second) << "the second of two threads never came";
  });
}

TEST(AwakeThread, WantsNoThread) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<std::size_t> squares(1000, 0);
  {
    const AwakeThread awake;
    parallelBlocks(squares.size(), 10, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) squares[i] = i * i;
    });
  }
  for (std::size_t i = 0; i < squares.size(); ++i) EXPECT_EQ(squares[i], i * i);
}

}  // namespace
}  // namespace deformable_contact_monitor
