// How the host ends what the device is doing: a word of its own memory that kernels look at.
#pragma once

#include <chrono>
#include <cstdint>
#include <thread>

#include "core/common/cycle_limit.h"
#include "core/common/stopwatch.h"
#include "cuda/device/stream.cuh"
#include "cuda/memory/device_buffer.cuh"

namespace deformable_contact_monitor {

// One detector's; one thread at a time.
class HostStop {
 public:
  // While the device is idle.
  void clear() { word_[0] = 0; }
  void set() { static_cast<volatile std::uint32_t&>(word_[0]) = 1; }
  // Not 0: kernels are to give up their rest.
  std::uint32_t* word() { return word_.data(); }

  // Waits for the stream, and sets the word once the limit is over. With a limit, the host sleeps
  // now and then where that takes long.
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
