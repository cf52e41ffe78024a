// Stage output: contacts from the device's unsorted list to the result's sorted one.
#pragma once

#include <cstdint>

#include "core/cycle_limit.h"
#include "core/detector.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/device_scene.cuh"

namespace deformable_contact_monitor {

// Of a sorted list, each contact once. A cycle that is cut off while lists of clusters have no room
// finds some twice: triangles without a list are as if each of their clusters were the only one.
void dropRepeated(DetectionResult& result);

// What comes with each contact.
struct ContactFields {
  bool separations, geometry;
  bool first_times, within_pad;  // in swept motion

  bool times() const { return first_times || within_pad; }
};

class ContactOutput {
 public:
  // Sorts on the device, adds the geometry, and copies, behind what is in the stream. A little more
  // than `count` contacts: as last cycle's count says, for the host does not know this one's
  // before.
  void fetch(const CycleArrays& cycle, const ContactFields& fields, unsigned index_bits,
             std::uint32_t count, cudaStream_t stream);
  // How many contacts the last fetch could bring.
  std::uint32_t fetched() const { return fetched_; }

  std::uint64_t bytes() const {
    return sorted_keys_.bytes() + sorted_separations_.bytes() + sorted_times_.bytes() +
           geometry_on_device_.bytes() + scratch_.bytes();
  }

  // The first `count` of them, once the stream has been waited for; where the limit is over, at
  // least kMostListedLate of them, if there are so many.
  void list(const DeviceScene& scene, std::uint32_t count, const CycleLimit& limit,
            DetectionResult& result) const;

 private:
  void listTimes(std::uint32_t count, DetectionResult& result) const;
  void makeRoom(std::uint32_t count, std::uint32_t most, const ContactFields& fields);

  DeviceBuffer<std::uint64_t> sorted_keys_;
  DeviceBuffer<float> sorted_separations_;
  DeviceBuffer<ContactTimes> sorted_times_;
  DeviceBuffer<PairGeometry> geometry_on_device_;
  DeviceBuffer<unsigned char> scratch_;
  PinnedBuffer<std::uint64_t> keys_;
  PinnedBuffer<float> separations_;
  PinnedBuffer<ContactTimes> times_;
  PinnedBuffer<PairGeometry> geometry_;
  std::uint32_t fetched_ = 0;
  unsigned index_bits_ = 1;
  ContactFields fields_{false, false, false, false};
};

}  // namespace deformable_contact_monitor
