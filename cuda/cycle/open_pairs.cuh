// Pairs of swept motion that the device leaves open, decided on the host.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/device_scene.cuh"

namespace deformable_contact_monitor {

// Of one detector and one cycle; of several passes, if need be.
class OpenPairs {
 public:
  void clear() {
    contacts_.clear();
    taken_ = 0;
  }
  // How many came since clear().
  std::uint64_t taken() const { return taken_; }

  // Fetches the first `count` of contacts.open_pairs, once the cycle that left them is over, and
  // decides them on threads; those that the limit leaves no time for are left out.
  void decide(const CycleArrays& cycle, std::uint32_t count, const Options& options,
              const CycleLimit& limit, cudaStream_t stream);

  // Adds the contacts among them to a sorted list.
  void addTo(const DeviceScene& scene, const Options& options, DetectionResult& result);

 private:
  struct Contact {
    std::uint64_t lower, higher;  // numbers of the triangles
    ContactTimes times;
  };

  PinnedBuffer<OpenPair> pairs_;
  std::vector<Contact> decided_;  // one for each pair; those that are none have equal numbers
  std::vector<Contact> contacts_;
  std::uint64_t taken_ = 0;
};

}  // namespace deformable_contact_monitor
