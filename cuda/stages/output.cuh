// Stage output: contacts from the device's unsorted list to the result's sorted one.
#pragma once

#include <cstdint>

#include "core/detector.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/stages/rows.cuh"

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
  // `blocks`: as many as a launch may well have.
  explicit ContactOutput(unsigned blocks) : blocks_(blocks) {}

  // Behind what is in the stream: the device brings the contacts into their order and writes them
  // to `contacts`, which lie in pinnedMemory(), as far as there is room: for `expected` at least,
  // and for more if there once were. Geometry of up to `most_described`. The stream must have been
  // waited for since the last fetch.
  void fetch(const CycleArrays& cycle, const ContactFields& fields, std::uint32_t expected,
             std::uint32_t most_described, TrianglePairs& contacts, cudaStream_t stream);
  // Once the stream has been waited for: whether the fetch brought the first `count` with all that
  // is asked for.
  bool has(std::uint32_t count) const {
    return too_long_[0] == 0 && count <= room_ && (!fields_.geometry || count <= described_);
  }
  // Makes room for so many contacts, while the device does not write any.
  void makeRoom(std::uint32_t count, TrianglePairs& contacts, cudaStream_t stream);
  // Where the fetch did not: brings the first `count`, or any, where they have to be sorted.
  void fetchAgain(const CycleArrays& cycle, unsigned index_bits, std::uint32_t count,
                  TrianglePairs& contacts, cudaStream_t stream);

  std::uint64_t bytes() const {
    return keys_.bytes() + sorted_separations_.bytes() + geometry_on_device_.bytes() +
           rows_.bytes();
  }

  // The first `count` of them, once the stream has been waited for; fewer, if no more came.
  void list(std::uint32_t count, DetectionResult& result) const;

 private:
  void write(const CycleArrays& cycle, TrianglePairs& contacts, cudaStream_t stream);
  OrderedOutput output(TrianglePairs& contacts);
  void describe(const CycleArrays& cycle, std::uint32_t most, cudaStream_t stream);
  void listTimes(std::uint32_t count, DetectionResult& result) const;

  const unsigned blocks_;
  ContactRows rows_;
  DeviceBuffer<std::uint64_t> keys_;
  DeviceBuffer<float> sorted_separations_;
  DeviceBuffer<PairGeometry> geometry_on_device_;
  PinnedBuffer<float> separations_;
  PinnedBuffer<ContactTimes> times_;
  PinnedBuffer<PairGeometry> geometry_;
  PinnedBuffer<std::uint32_t> too_long_{1};
  bool gathered_ = false;  // into rows, by the last fetch
  std::uint32_t room_ = 0, described_ = 0;
  ContactFields fields_{false, false, false, false};
};

}  // namespace deformable_contact_monitor
