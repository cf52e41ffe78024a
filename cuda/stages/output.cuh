// Stage output: sorts the contacts on the device and brings them into the result on the host.
#pragma once

#include <cstdint>

#include "core/detector.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/stages/rows.cuh"

namespace deformable_contact_monitor {

// Removes repeated contacts from a sorted list. A cycle that is cut off before lists of clusters
// have room finds some pairs several times: a triangle without a list counts as if it were in one
// cluster only.
void dropRepeated(DetectionResult& result);

// States which fields are wanted for each contact.
struct ContactFields {
  bool separations, geometry;
  bool first_times, within_pad;  // in swept motion

  bool times() const { return first_times || within_pad; }
  bool ofContacts() const { return separations || times(); }
};

// Belongs to one detector; for one thread at a time.
class ContactOutput {
 public:
  // `blocks`: the number of blocks of each launch.
  explicit ContactOutput(unsigned blocks) : blocks_(blocks) {}

  // Enqueues the sort of the contacts, which may order them in place, and their transfer to the
  // result, whose contacts and geometry must be in pinnedMemory(). There is room for at least
  // `expected` contacts, and for more if there once was; others are not written. Geometry comes
  // with up to `most_described` contacts. The stream must have been waited for since the last
  // fetch.
  void fetch(const CycleArrays& cycle, const ContactFields& fields, std::uint32_t expected,
             std::uint32_t most_described, DetectionResult& result, cudaStream_t stream);
  // Returns whether the fetch brought the first `count` contacts with all fields. The stream must
  // have been waited for.
  bool has(std::uint32_t count) const {
    return too_long_[0] == 0 && count <= room_ && (!fields_.geometry || count <= described_);
  }
  // Makes room for `count` contacts. The device must not be writing contacts.
  void makeRoom(std::uint32_t count, DetectionResult& result, cudaStream_t stream);
  // Brings the first `count` contacts if fetch() did not. If rows were too long, it sorts and
  // brings any `count` of them.
  void fetchAgain(const CycleArrays& cycle, unsigned index_bits, std::uint32_t count,
                  DetectionResult& result, cudaStream_t stream);

  std::uint64_t bytes() const { return from_.bytes() + open_.bytes() + rows_.bytes(); }

  // Copies the first `count` contacts to the result, or fewer if fewer came. The stream must have
  // been waited for.
  void list(std::uint32_t count, DetectionResult& result) const;

 private:
  OrderStatus status();
  void orderAndWrite(const CycleArrays& cycle, std::uint32_t most_described,
                     DetectionResult& result, cudaStream_t stream);
  void describeAndWrite(const CycleArrays& cycle, const OrderedContacts& ordered,
                        const ContactsOnHost& to, std::uint32_t most_described,
                        DetectionResult& result, cudaStream_t stream);
  ContactsOnHost onHost(DetectionResult& result);
  void listTimes(std::uint32_t count, DetectionResult& result) const;

  const unsigned blocks_;
  ContactRows rows_;
  DeviceBuffer<Place> from_;                       // see OrderedContacts
  DeviceBuffer<std::uint32_t> open_, open_count_;  // see GeometryOutput
  PinnedBuffer<float> separations_;
  PinnedBuffer<ContactTimes> times_;
  PinnedBuffer<std::uint32_t> too_long_{1};
  bool gathered_ = false;  // the last fetch grouped contacts into rows
  std::uint32_t room_ = 0, described_ = 0;
  ContactFields fields_{false, false, false, false};
};

}  // namespace deformable_contact_monitor
