// Tells how much memory this process takes of a device.
#pragma once

#include <cstdint>
#include <mutex>
#include <set>

namespace deformable_contact_monitor {

// An amount of device memory, as DetectionResult tells it.
struct MemoryUse {
  std::uint64_t bytes = 0;
  bool is_whole = false;  // otherwise only what this library allocated is counted
};

// Counts what this process takes of one device: arrays, the reserve, kernels and the stacks of
// their threads, and the driver's context. Only the driver knows the whole, so it is asked through
// NVML (libnvidia-ml.so.1, which comes with the driver and is opened at run time). Differences of
// free memory would count what other processes allocate meanwhile. NVML does not tell on Jetson,
// and not in containers that number processes by themselves; then only DevicePool is counted. All
// functions may be called by any thread.
class ProcessMemory {
 public:
  // Returns the one of a device, which is never destroyed.
  static ProcessMemory& of(int device);

  explicit ProcessMemory(int device) : device_(device) {}
  ProcessMemory(const ProcessMemory&) = delete;
  ProcessMemory& operator=(const ProcessMemory&) = delete;

  // Returns what the process takes, after a cycle of that kind on the device, which must be the
  // current one. Asking NVML takes longer than a cycle; so it is asked after the first cycle of
  // each kind, whose kernels may be new, and when DevicePool has grown or shrunk.
  MemoryUse afterCycle(unsigned kind);

 private:
  const int device_;
  std::mutex mutex_;
  std::set<unsigned> kinds_;
  std::uint64_t pooled_bytes_ = 0;  // when NVML was asked last
  MemoryUse last_;
};

}  // namespace deformable_contact_monitor
