// Lets kernels end a cycle early. The host sets a word in its own memory. The first thread that
// sees it sets counters().cut_off, and all threads give up the work that they have not begun.
#pragma once

#include "cuda/device/warp.cuh"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Returns whether the cycle is cut off. Each thread asks before each piece of work, which takes
// well below a millisecond. `ask_host`: also reads the host's memory. That takes a microsecond or
// two and uses the bus, so only one thread in hundreds does it. Some thread that does must run as
// long as the others do.
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

// Does the same for a whole warp: its first lane asks for all lanes.
__device__ inline bool warpIsCutOff(const CycleArrays& c, bool ask_host) {
  if (c.params().limited == 0) return false;
  const int cut_off = laneId() == 0 && isCutOff(c, ask_host) ? 1 : 0;
  return __shfl_sync(kFullWarp, cut_off, 0) != 0;
}

// One warp in so many asks the host, in kernels whose warps all run equally long.
constexpr std::uint32_t kWarpsPerAsker = 32;

// Asks once in so many steps, for threads whose steps are short.
class PacedCutOff {
 public:
  __device__ PacedCutOff(const CycleArrays& c, bool asks_host) : c_(c), asks_host_(asks_host) {}

  // Returns whether the cycle is cut off. `steps`: how many were made since the last call.
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
