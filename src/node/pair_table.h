// Which pairs of bodies are monitored, and which of them are allowed to touch.
#pragma once

#include <deformable_contact_monitor/AllowedContact.h>

#include <string>
#include <vector>

#include "node/cycle_report.h"

namespace deformable_contact_monitor {

// What is looked for. A class that is off costs nothing.
struct PairClasses {
  bool robot_deformable = true;        // links with objects
  bool deformable_deformable = false;  // objects with other objects
  bool deformable_self = false;        // objects with themselves
  bool robot_self = false;             // links with other links

  bool needRobot() const { return robot_deformable || robot_self; }
};

// Rules in force. A rule that names both bodies beats one with a wildcard ('*': any body), which
// beats one with two; among equals the one added last wins. Without a rule: not allowed. The order
// of a rule's bodies does not matter.
class AllowedContacts {
 public:
  // Replaces an earlier rule for the same two names. Throws std::invalid_argument if a name is
  // empty.
  void add(const AllowedContact& rule);

  bool allows(const std::string& a, const std::string& b) const;

  // In the order in which they were added.
  const std::vector<AllowedContact>& rules() const { return rules_; }

 private:
  std::vector<AllowedContact> rules_;
};

// The pairs of the classes that are on, ascending, allowed ones marked.
std::vector<MonitoredPair> monitoredPairs(const std::vector<BodyStatus>& bodies,
                                          const PairClasses& classes,
                                          const AllowedContacts& allowed);

}  // namespace deformable_contact_monitor
