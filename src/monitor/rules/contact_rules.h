// Who may touch whom, and who says so.
#pragma once

#include <deformable_contact_monitor/AllowedContact.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "monitor/cycle_report.h"
#include "robot/srdf.h"

namespace deformable_contact_monitor {

enum class RuleSource : std::uint8_t { kDefault, kParameters, kService, kAttached, kSrdf };

// "default", "parameters", "service", "attached", "srdf".
const char* toString(RuleSource source);

struct ContactVerdict {
  bool allowed = false;
  RuleSource source = RuleSource::kDefault;
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
  void add(const AllowedContact& rule, RuleSource source = RuleSource::kParameters);

  // By the service. All of it or nothing: throws as add() does, and at the removal of a rule that
  // is not there.
  void change(const AllowedContactsChange& change);

  // What the rule for these two says, or the strongest one with a wildcard; nothing: there is
  // none. In time that hardly grows with the number of rules.
  std::optional<ContactVerdict> ofPair(const std::string& a, const std::string& b) const;
  std::optional<ContactVerdict> ofWildcard(const std::string& a, const std::string& b) const;

  // As if there were no other rules.
  bool allows(const std::string& a, const std::string& b) const;

  // In the order in which they were added.
  std::vector<AllowedContact> rules() const;
  std::size_t count() const { return rules_.size(); }
  std::size_t count(RuleSource source) const;

 private:
  using Names = std::pair<std::string, std::string>;
  struct Rule {
    AllowedContact rule;
    RuleSource source = RuleSource::kParameters;
    std::uint64_t added = 0;  // counts up

    ContactVerdict verdict() const { return {rule.allowed != 0, source}; }
  };

  static Names namesOf(const AllowedContact& rule);
  const Rule* find(const std::string& a, const std::string& b) const;

  std::map<Names, Rule> rules_;
  std::uint64_t added_ = 0;
};

// The links' part of it: an SRDF's rules, to be asked often.
class LinkRules {
 public:
  LinkRules() = default;
  explicit LinkRules(const Srdf& srdf);

  // As the SRDF says, false without a rule.
  bool allows(const std::string& a, const std::string& b) const;
  std::size_t count() const { return pairs_.size() + links_.size(); }

 private:
  std::map<std::pair<std::string, std::string>, bool> pairs_;
  std::set<std::string> links_;
};

// All rules that are in force. The strongest that speaks of a pair decides: a rule of parameters or
// service that names both bodies; an attached object with a link that holds it; a rule of
// parameters or service with a wildcard; for two links, the SRDF. Without one: not allowed.
struct ContactRules {
  AllowedContacts allowed;
  AttachedObjects attached;
  LinkRules links;

  ContactVerdict verdict(const BodyStatus& a, const BodyStatus& b) const;
};

}  // namespace deformable_contact_monitor
