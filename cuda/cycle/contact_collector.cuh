// Collects the contacts of a cycle: brings them from the device into the result, sorted, and adds
// those that the host decided.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "cuda/cycle/device_cycle.cuh"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/device_scene.cuh"
#include "cuda/stages/output.cuh"

namespace deformable_contact_monitor {

// Decides on the host the pairs of swept motion for which the device's arithmetic does not suffice.
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

// Belongs to one detector. Each cycle calls begin(), then fetch() and what the runner needs of the
// other functions, then addTo().
class ContactCollector {
 public:
  // `cycle` and `result` must outlive this. The contacts of `result` must lie in page-locked
  // memory.
  ContactCollector(DeviceCycle& cycle, DetectionResult& result)
      : cycle_(cycle), result_(result), output_(8 * cycle.device.multiprocessors) {}

  // Clears the state of the last cycle.
  void begin();

  // Enqueues the fetch of the contacts, ordered after the work in the stream. If a limit is set, it
  // fetches at most as many as take little time.
  void fetch(const Options& options, const CycleLimit& limit);
  // Fetches the contacts that fetch() had no room for. Call it after the stream has been waited
  // for, when the number of contacts is known. It may wait for the device.
  void complete(const CycleLimit& limit);

  // Drops the pairs that were left to the host, because the next pass finds them again.
  void dropOpenPairs() {
    open_pairs_.clear();
    all_had_room_ = true;
  }
  // Decides on the host the pairs that the last cycle or pass left open.
  void decideOpenPairs(const Options& options, const CycleLimit& limit);

  // Writes the contacts, their geometry and times into the result. Returns whether the result has
  // all contacts for which the device's list has room.
  bool addTo(const Options& options);

  // Returns whether the limit left time for all pairs that were left to the host.
  bool allDecided() const { return all_decided_; }
  // Returns whether all pairs that the device left to the host had room, and so were decided.
  bool hadRoomForOpenPairs() const { return all_had_room_; }
  // Return how many pairs the host decided, and how long that took [ms].
  std::uint64_t decidedOnHost() const { return open_pairs_.taken(); }
  double decideMs() const { return decide_ms_; }
  // Returns the device memory of the output [bytes].
  std::uint64_t bytes() const { return output_.bytes(); }

 private:
  DeviceCycle& cycle_;
  DetectionResult& result_;
  ContactOutput output_;
  OpenPairs open_pairs_;
  double decide_ms_ = 0;
  bool all_decided_ = true;
  bool all_had_room_ = true;
  std::uint64_t last_contacts_ = 0;  // of the last cycle: an estimate for the next one
};

}  // namespace deformable_contact_monitor
