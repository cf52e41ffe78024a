// Which pairs of bodies are monitored, and which of them are allowed to touch.
#pragma once

#include <deformable_contact_monitor/AllowedContact.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
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

struct AllowedContactsChange {
  bool replace = false;                // all rules in force go first
  std::vector<AllowedContact> remove;  // then these, by their bodies' names
  std::vector<AllowedContact> add;
};

// Rules in force. A rule that names both bodies beats one with a wildcard ('*': any body), which
// beats one with two; among equals the one added last wins. Without a rule: not allowed. The order
// of a rule's bodies does not matter.
class AllowedContacts {
 public:
  // So many rules are held at most.
  static constexpr std::size_t kMostRules = 100000;

  // Replaces an earlier rule for the same two names. Throws std::invalid_argument if a name is
  // empty, or kMostRules are there.
  void add(const AllowedContact& rule);

  // All of it or nothing: throws as add() does, and at the removal of a rule that is not there.
  void change(const AllowedContactsChange& change);

  // In time that hardly grows with the number of rules.
  bool allows(const std::string& a, const std::string& b) const;

  // In the order in which they were added.
  std::vector<AllowedContact> rules() const;
  std::size_t count() const { return rules_.size(); }

 private:
  using Names = std::pair<std::string, std::string>;
  struct Rule {
    AllowedContact rule;
    std::uint64_t added = 0;  // counts up
  };

  static Names namesOf(const AllowedContact& rule);
  const Rule* find(const std::string& a, const std::string& b) const;

  std::map<Names, Rule> rules_;
  std::uint64_t added_ = 0;
};

// The pairs of the classes that are on, ascending, allowed ones marked.
std::vector<MonitoredPair> monitoredPairs(const std::vector<BodyStatus>& bodies,
                                          const PairClasses& classes,
                                          const AllowedContacts& allowed);

}  // namespace deformable_contact_monitor
