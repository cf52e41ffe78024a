// Decides on the host the pairs of swept motion for which the device's arithmetic does not suffice.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/device_scene.cuh"

namespace deformable_contact_monitor {

// Belongs to one detector. Collects such pairs over one cycle, which may have several passes.
class OpenPairs {
 public:
  void clear() {
    contacts_.clear();
    taken_ = 0;
  }
  // Returns how many pairs were fetched since clear().
  std::uint64_t taken() const { return taken_; }

  // Fetches the first `count` of contacts.open_pairs and decides them on several threads. The
  // stream must have been waited for. Pairs for which the limit leaves no time are left out.
  void decide(const CycleArrays& cycle, std::uint32_t count, const Options& options,
              const CycleLimit& limit, cudaStream_t stream);

  // Adds those pairs that are contacts to the sorted lists of the result.
  void addTo(const DeviceScene& scene, const Options& options, DetectionResult& result);

 private:
  struct Contact {
    std::uint64_t lower, higher;  // numbers of the two triangles
    ContactTimes times;
  };

  PinnedBuffer<OpenPair> pairs_;
  // One element for each pair; lower == higher marks a pair that is no contact.
  std::vector<Contact> decided_;
  std::vector<Contact> contacts_;
  std::uint64_t taken_ = 0;
};

}  // namespace deformable_contact_monitor
