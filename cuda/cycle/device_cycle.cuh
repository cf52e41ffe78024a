// Holds the state that one GPU's detector keeps from cycle to cycle: stream, device arrays, scene,
// settings and counters. The parts of the detector (CycleUpload, CycleRunner, ContactCollector)
// work on it.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>

#include "core/common/cycle_limit.h"
#include "core/common/stopwatch.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/stream.cuh"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/device_nearest.cuh"
#include "cuda/memory/device_scene.cuh"
#include "cuda/memory/host_copy.cuh"
#include "cuda/stages/stages.cuh"

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

// Belongs to one detector, and is used by one thread at a time. The order of the fields matters:
// the stream must outlive all memory that was allocated in it.
struct DeviceCycle {
  // Prepares the state for settings.device, which must be the current device. Throws CudaError.
  explicit DeviceCycle(const CudaSettings& settings);
  DeviceCycle(const DeviceCycle&) = delete;
  DeviceCycle& operator=(const DeviceCycle&) = delete;

  // Grows the device arrays to `sizes`, and sets the counts of clusters and samples. The contents
  // of the arrays are kept.
  void growArrays();

  // Adds `params` to `copies`, unless the device already has the same values.
  void addParams();
  // Makes the next addParams() send the settings in any case.
  void forgetSentParams() { params_sent_ = false; }

  // Enqueues the settings, and zeros for all counters and arrays that the kernels add to.
  void start(const CycleShape& shape);

  // Returns which steps the next cycle needs. `refinements`: steps of fuzzy c-means.
  CycleShape shapeOf(const Options& options, int refinements) const;

  // Returns how many of `contacts` have a place on the device's list.
  std::uint32_t listable(std::uint64_t contacts) const {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(contacts, sizes.contacts));
  }

  // Waits for the stream; sets the stop word for the kernels once the limit is over.
  void wait(const CycleLimit& limit) { stop.wait(stream, limit); }

  // Returns the counters of the last cycle, once the stream has been waited for.
  const CycleCounters& counted() const { return counters[0]; }

  const CudaSettings settings;
  const DeviceTraits device;
  CudaStream stream;
  HostCopies copies{stream.get()};  // collects this cycle's copies until a kernel makes them
  DeviceMemory memory;
  CycleSizes sizes;
  CycleArrays arrays{memory};
  DeviceScene scene{settings.device, memory, sizes, arrays.scene};
  DeviceNearest nearest{sizes, arrays.nearest};
  PinnedBuffer<CycleParams> params{1};
  PinnedBuffer<CycleCounters> counters{1};
  HostStop stop;
  int cycles_since_refresh = 0;  // cycles since the prototypes were refined or set

 private:
  CycleParams sent_params_;
  bool params_sent_ = false;  // sent_params_ are on the device
};

}  // namespace deformable_contact_monitor
