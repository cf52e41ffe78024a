// Collects the contacts of a cycle: brings them from the device into the result, sorted, and adds
// those that the host decided.
#pragma once

#include <cstdint>

#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "cuda/cycle/device_cycle.cuh"
#include "cuda/cycle/open_pairs.cuh"
#include "cuda/stages/output.cuh"

namespace deformable_contact_monitor {

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
  void dropOpenPairs() { open_pairs_.clear(); }
  // Decides on the host the pairs that the last cycle or pass left open.
  void decideOpenPairs(const Options& options, const CycleLimit& limit);

  // Writes the contacts, their geometry and times into the result. Returns whether the result has
  // all contacts for which the device's list has room.
  bool addTo(const Options& options);

  // Returns whether the limit left time for all pairs that were left to the host.
  bool allDecided() const { return all_decided_; }
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
  std::uint64_t last_contacts_ = 0;  // of the last cycle: an estimate for the next one
};

}  // namespace deformable_contact_monitor
