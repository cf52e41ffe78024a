// Lets the host stop a running cycle: kernels poll a word in the host's memory
// (stages/cut_off.cuh).
#pragma once

#include <chrono>
#include <cstdint>
#include <thread>

#include "core/common/cycle_limit.h"
#include "core/common/stopwatch.h"
#include "cuda/device/stream.cuh"
#include "cuda/memory/device_buffer.cuh"

namespace deformable_contact_monitor {

// Belongs to one detector; for one thread at a time.
class HostStop {
 public:
  // Clears the word. Call it while the device is idle.
  void clear() { word_[0] = 0; }
  void set() { static_cast<volatile std::uint32_t&>(word_[0]) = 1; }
  // Returns the word. If it is not 0, kernels give up the work that they have not begun.
  std::uint32_t* word() { return word_.data(); }

  // Waits for the stream, and sets the word once the limit is over. If a limit is set, it polls the
  // stream, and after 2 ms sleeps between two polls.
  void wait(CudaStream& stream, const CycleLimit& limit) {
    constexpr double kAwakeMs = 2;
    constexpr std::chrono::microseconds kSleep(50);
    const Stopwatch watch{};
    while (limit.isSet() && !stream.isIdle()) {
      if (limit.over()) {
        set();
        break;
      }
      if (watch.elapsedMs() > kAwakeMs) std::this_thread::sleep_for(kSleep);
    }
    stream.synchronise();
  }

 private:
  PinnedBuffer<std::uint32_t> word_{1};
};

}  // namespace deformable_contact_monitor
