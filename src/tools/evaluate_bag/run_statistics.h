// Counts over the cycles of one run: the time intervals of swept motion, and the reasons why pairs
// of bodies were UNKNOWN.
//
// EvaluationRun feeds both classes after every cycle.
#pragma once

#include <deformable_contact_monitor/ContactEvent.h>
#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/detector.h"
#include "monitor/cycle_report.h"
#include "monitor/state/contact_state_tracker.h"

namespace deformable_contact_monitor {

// Collects what one run finds in the time intervals between the cycles. The class stays empty in
// instant motion.
class RunSteps {
 public:
  // Takes the intervals of a cycle with their results, and adds them to the sums.
  void look(const CycleReport& cycle);

  // Takes the tracker's events. Call it after the tracker was updated with the cycle.
  void takeEvents(ContactStateTracker* tracker);

  // These describe the latest cycle.
  const std::vector<SweepReport>& sweeps() const { return sweeps_; }
  const std::vector<ContactEvent>& events() const { return events_; }
  // Returns where the interval of a PASSED event begins; zero if no interval has the event's pair.
  ros::Time beginningOf(const CycleReport& cycle, const ContactEvent& event) const;
  // Returns the triangle pairs of all intervals of the cycle.
  std::uint64_t pairsOfCycle() const;
  // Returns true if all intervals of the cycle are complete.
  bool isCycleComplete(const CycleReport& cycle) const;
  // Returns the time that the intervals of the cycle took [ms].
  double msOfCycle() const;

  // Sums over all cycles.
  struct Sums {
    std::uint64_t cycles = 0;      // cycles with an interval
    std::uint64_t complete = 0;    // cycles whose intervals are all complete
    std::uint64_t pairs = 0;       // triangle pairs
    std::uint64_t within_pad = 0;  // pairs that may touch only within the motion bound
    std::uint64_t passed = 0;      // PASSED events
    double most_pad_m = 0;         // the largest motion bound [m]
    int most_sub_steps = 0;        // the largest number of sub-steps
    std::vector<double> ms;        // time of each cycle's intervals [ms]
  };
  const Sums& sums() const { return sums_; }

 private:
  std::vector<SweepReport> sweeps_;
  std::vector<ContactEvent> events_;
  Sums sums_;
};

// Returns true if no contact of the interval can be missing, as SweptContacts.complete defines it.
bool isComplete(const CycleReport& cycle, const SweepReport& sweep);

// One reason of UNKNOWN, with all cycles that have it.
struct UnknownReason {
  std::string text;          // as in the first cycle; later cycles may have other numbers in it
  std::uint64_t cycles = 0;  // cycles in which a pair was UNKNOWN for this reason
  ros::Time from, to;        // stamps of the first and the last of them
};

// Counts why pairs of bodies were UNKNOWN. Reasons that differ only in numbers, such as stamps,
// count as one.
class UnknownReasons {
 public:
  // Takes a cycle and the states after it.
  void look(const CycleReport& cycle, const ContactStates& states);

  // Returns the number of cycles in which at least one pair was not UNKNOWN.
  std::uint64_t evaluatedCycles() const { return evaluated_; }

  // Returns the most frequent reason first; of equally frequent ones, the earlier first.
  std::vector<UnknownReason> all() const;

 private:
  std::map<std::string, UnknownReason> reasons_;  // by their texts without numbers
  std::uint64_t evaluated_ = 0;
};

}  // namespace deformable_contact_monitor
