// How kernels learn that the cycle is to end early: the host sets a word in its own memory, whoever
// sees that sets counters().cut_off, and all give up what they have not begun.
#pragma once

#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// To be asked ahead of each piece of work, which takes well below a millisecond. `ask_host`: looks
// into the host's memory too, which takes a microsecond or two and a share of the bus: for one
// thread in hundreds, but always for some that run as long as the others.
__device__ inline bool isCutOff(const CycleArrays& c, bool ask_host) {
  if (c.params().limited == 0) return false;
  volatile std::uint32_t& cut_off = c.counters().cut_off;
  if (cut_off != 0) return true;
  if (!ask_host || *static_cast<const volatile std::uint32_t*>(c.host_stop.onHost()) == 0) {
    return false;
  }
  cut_off = 1;
  return true;
}

// The same for a whole warp.
__device__ inline bool warpIsCutOff(const CycleArrays& c, bool ask_host) {
  if (c.params().limited == 0) return false;
  const int cut_off = laneId() == 0 && isCutOff(c, ask_host) ? 1 : 0;
  return __shfl_sync(kFullWarp, cut_off, 0) != 0;
}

// One warp in so many asks the host, where all of a kernel's warps run as long.
constexpr std::uint32_t kWarpsPerAsker = 32;

// For a thread whose steps are short: asks once in so many of them.
class PacedCutOff {
 public:
  __device__ PacedCutOff(const CycleArrays& c, bool asks_host) : c_(c), asks_host_(asks_host) {}

  // To be asked after so many more steps.
  __device__ bool isOver(std::uint32_t steps) {
    constexpr std::uint32_t kSteps = 2048;
    done_ += steps;
    if (done_ >= kSteps) {
      done_ = 0;
      over_ = over_ || isCutOff(c_, asks_host_);
    }
    return over_;
  }
  __device__ bool wasOver() const { return over_; }

 private:
  const CycleArrays& c_;
  bool asks_host_, over_ = false;
  std::uint32_t done_ = 0;
};

}  // namespace deformable_contact_monitor
