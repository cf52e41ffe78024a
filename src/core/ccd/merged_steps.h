// One result of a step's parts.
#pragma once

#include <vector>

#include "core/detector.h"

namespace deformable_contact_monitor {

// Collects what detections of parts of a step found: in time, or of other pairs of bodies.
class MergedSteps {
 public:
  // Of swept motion from `from` to `to`, parts [0, 1] of the step. Sorted.
  void add(const DetectionResult& part, double from, double to);

  bool isCutOff() const { return sums_.cut_off; }

  // Into a result that has begun, which says whether the step is `guaranteed`: contacts, each once,
  // with the earliest of their times, rounded outwards; sums of counters and times.
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
