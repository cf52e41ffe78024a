// Why pairs of bodies were UNKNOWN in an evaluation, counted.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

struct UnknownReason {
  std::string text;          // of the first cycle; later ones may have other numbers in it
  std::uint64_t cycles = 0;  // in which a pair was UNKNOWN for it
  ros::Time from, to;        // the first and the last of them
};

class UnknownReasons {
 public:
  // Every cycle, with the states after it.
  void look(const CycleReport& cycle, const ContactStates& states);

  // Cycles that found out about one of their pairs at least.
  std::uint64_t evaluatedCycles() const { return evaluated_; }

  // The commonest first, of equals the earlier.
  std::vector<UnknownReason> all() const;

 private:
  std::map<std::string, UnknownReason> reasons_;  // by their texts without numbers
  std::uint64_t evaluated_ = 0;
};

}  // namespace deformable_contact_monitor
