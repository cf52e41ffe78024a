// Swept motion in an evaluation: what a run finds between the cycles.
#pragma once

#include <deformable_contact_monitor/ContactEvent.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/detector.h"
#include "monitor/cycle_report.h"
#include "monitor/state/contact_state_tracker.h"

namespace deformable_contact_monitor {

struct SetDifference;

// Of one run.
class RunSteps {
 public:
  // A cycle's steps, with their results. Does nothing where there are none.
  void look(const CycleReport& cycle);

  // Once the tracker knows the cycle.
  void takeEvents(ContactStateTracker* tracker);

  // Of the latest cycle.
  const std::vector<SweepReport>& sweeps() const { return sweeps_; }
  const std::vector<ContactEvent>& events() const { return events_; }
  // Beginning of the step that an event PASSED is of.
  ros::Time beginningOf(const CycleReport& cycle, const ContactEvent& event) const;
  std::uint64_t pairsOfCycle() const;
  bool isCycleComplete(const CycleReport& cycle) const;
  double msOfCycle() const;

  // Of all cycles.
  struct Sums {
    std::uint64_t cycles = 0, complete = 0;  // with a step; with complete ones alone
    std::uint64_t pairs = 0, within_pad = 0;
    std::uint64_t passed = 0;  // events
    double most_pad_m = 0;
    int most_sub_steps = 0;
    std::vector<double> ms;  // of a cycle's steps
  };
  const Sums& sums() const { return sums_; }

 private:
  std::vector<SweepReport> sweeps_;
  std::vector<ContactEvent> events_;
  Sums sums_;
};

// Whether nothing can be missing: as SweptContacts.complete says it.
bool isComplete(const CycleReport& cycle, const SweepReport& sweep);

// How the contacts of two runs' steps differ in a cycle. Steps that one of them has no result of
// count as without a contact.
SetDifference difference(const Scene& scene, const RunSteps& a, const RunSteps& b);

}  // namespace deformable_contact_monitor
