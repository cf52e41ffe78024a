// Which pairs of bodies are monitored, and which of them are allowed to touch.
#pragma once

#include <string>
#include <tuple>
#include <vector>

#include "monitor/cycle_report.h"
#include "monitor/rules/contact_rules.h"

namespace deformable_contact_monitor {

// What is looked for. A class that is off costs nothing.
struct PairClasses {
  bool robot_deformable = true;        // links with objects
  bool deformable_deformable = false;  // objects with other objects
  bool deformable_self = false;        // objects with themselves
  bool robot_self = false;             // links with other links

  bool needRobot() const { return robot_deformable || robot_self; }

  bool operator==(const PairClasses& other) const {
    const auto all = [](const PairClasses& c) {
      return std::tie(c.robot_deformable, c.deformable_deformable, c.deformable_self, c.robot_self);
    };
    return all(*this) == all(other);
  }
};

// Of those that are on, as the parameter pair_classes has them.
std::vector<std::string> namesOf(const PairClasses& classes);

// The pairs of the classes that are on, ascending, allowed ones marked.
std::vector<MonitoredPair> monitoredPairs(const std::vector<BodyStatus>& bodies,
                                          const PairClasses& classes, const ContactRules& rules);

}  // namespace deformable_contact_monitor
