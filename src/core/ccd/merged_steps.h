// Merges the results of sub-steps into one result for the whole time interval.
#pragma once

#include <vector>

#include "core/detector.h"

namespace deformable_contact_monitor {

// Collects the results of several detections. Each of them covered a part of the time interval, or
// other pairs of bodies.
class MergedSteps {
 public:
  // Adds the result of a detection with swept motion in [from, to], parts [0, 1] of the interval.
  void add(const DetectionResult& part, double from, double to);

  bool isCutOff() const { return sums_.cut_off; }

  // Writes into a result that has begun and whose `guaranteed` is set: each contact once, with the
  // earliest of its times, rounded outwards, and the sums of counters and stage times.
  // `first_times` and `pads` tell which of the lists beside the contacts are wanted.
  void write(bool first_times, bool pads, DetectionResult* result) const;

 private:
  struct Contact {
    TrianglePair pair;
    FirstContact first;
    bool within_pad;
  };

  void addContacts(const DetectionResult& part, double from, double to);
  static Contact merged(const Contact& earlier, const Contact& later);

  std::vector<Contact> contacts_, new_, both_;  // sorted
  DetectionResult sums_;
};

}  // namespace deformable_contact_monitor
