// Decides which pairs of bodies are monitored and which of them may touch.
//
// Rules come from four sources: the parameters (~allowed_contacts), the service
// ~set_allowed_contacts, attached objects (~attach_object) and the robot's SRDF. A pair that may
// touch is ALLOWED: the detector does not compute it. ContactRules::verdict() defines which rule
// decides; config/README.md ("What may touch") explains the same order to users.
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
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Selects the kinds of pairs that are monitored. A class that is off costs nothing.
struct PairClasses {
  bool robot_deformable = true;        // links with objects that deform
  bool deformable_deformable = false;  // these with one another
  bool deformable_self = false;        // these with themselves
  bool robot_self = false;             // links with other links
  bool deformable_rigid = false;       // rigid objects with objects that deform
  bool robot_rigid = false;            // rigid objects with links

  bool needRobot() const { return robot_deformable || needRobotCycles(); }
  // Returns whether there are pairs without a deformable object, which the robot's own cycles are
  // about.
  bool needRobotCycles() const { return robot_self || robot_rigid; }

  bool operator==(const PairClasses& other) const;
};

// A class of pairs with its name in the parameter pair_classes.
struct NamedPairClass {
  const char* name;
  bool PairClasses::*is_on;
};
// All of them, in the order of the documentation.
constexpr NamedPairClass kPairClasses[] = {
    {"robot_deformable", &PairClasses::robot_deformable},
    {"deformable_deformable", &PairClasses::deformable_deformable},
    {"deformable_self", &PairClasses::deformable_self},
    {"robot_self", &PairClasses::robot_self},
    {"deformable_rigid", &PairClasses::deformable_rigid},
    {"robot_rigid", &PairClasses::robot_rigid}};

// Returns the names of the classes that are on, as the parameter pair_classes lists them.
std::vector<std::string> namesOf(const PairClasses& classes);

// Names where the rule that decides a pair comes from; kDefault: no rule covers the pair.
enum class RuleSource : std::uint8_t { kDefault, kParameters, kService, kAttached, kSrdf };

// Returns "default", "parameters", "service", "attached" or "srdf".
const char* toString(RuleSource source);

// The decision about one pair, and the source of the rule that decides.
struct ContactVerdict {
  bool allowed = false;
  RuleSource source = RuleSource::kDefault;
};

// One request to ~set_allowed_contacts. The steps are made in the order of the fields.
struct AllowedContactsChange {
  bool replace = false;                // removes all rules in force
  std::vector<AllowedContact> remove;  // removes these, found by their bodies' names
  std::vector<AllowedContact> add;
};

// Holds the rules of the parameters and of the service. A rule that names both bodies beats a rule
// with one wildcard ('*', any body), which beats a rule with two. Among equals the rule that was
// added last wins. Without a rule the pair is not allowed. The order of a rule's bodies does not
// matter. Not safe for use by several threads.
class AllowedContacts {
 public:
  static constexpr std::size_t kMostRules = 100000;  // bounds memory, whatever a client sends

  // Adds a rule, which replaces an earlier rule for the same two names. Throws
  // std::invalid_argument if a name is empty or kMostRules rules exist.
  void add(const AllowedContact& rule, RuleSource source = RuleSource::kParameters);

  // Applies the whole change, or nothing of it: throws std::invalid_argument like add(), and if a
  // rule to be removed does not exist. Added rules have the source kService.
  void change(const AllowedContactsChange& change);

  // The names by which rules may mean one side of a pair, from the least to the most particular
  // one: "cloth", and of a part of it then "cloth:*", "cloth:hem", "cloth:held".
  using RuleNames = std::vector<std::string>;

  // Returns what the rule for exactly these two sides says, or what the strongest rule with a
  // wildcard says; nothing if no such rule exists. Of several the most particular one decides: the
  // names of both sides count, and among equals the last one wins. Takes logarithmic time.
  std::optional<ContactVerdict> ofPair(const RuleNames& a, const RuleNames& b) const;
  std::optional<ContactVerdict> ofWildcard(const RuleNames& a, const RuleNames& b) const;

  // Returns whether the pair may touch if these rules are the only ones.
  bool allows(const std::string& a, const std::string& b) const;

  // Returns the rules in the order in which they were added.
  std::vector<AllowedContact> rules() const;
  std::size_t count() const { return rules_.size(); }
  // Returns how many rules come from that source.
  std::size_t count(RuleSource source) const;

 private:
  using Names = std::pair<std::string, std::string>;  // ascending
  struct Rule {
    AllowedContact rule;
    RuleSource source = RuleSource::kParameters;
    std::uint64_t added = 0;  // counts up; decides among equals

    ContactVerdict verdict() const { return {rule.allowed != 0, source}; }
  };

  // A rule with a number that grows with how particular its names are.
  struct Ranked {
    const Rule* rule = nullptr;
    std::size_t rank = 0;

    bool beats(const Ranked& other) const;
  };

  static Names namesOf(const AllowedContact& rule);
  Ranked findBest(const RuleNames& a, const RuleNames& b) const;
  const Rule* find(const std::string& a, const std::string& b) const;

  std::map<Names, Rule> rules_;
  std::uint64_t added_ = 0;
};

// Holds the rules of SRDFs between links, indexed for fast look-ups. A rule holds only between two
// links of its own robot, or such a link and a rigid object.
class LinkRules {
 public:
  LinkRules() = default;
  explicit LinkRules(const std::vector<DescribedRobot>& robots);

  // Returns what the robot's SRDF says of two links, or of a link and a rigid object; false without
  // a rule.
  bool allows(const BodyStatus& a, const BodyStatus& b) const;
  std::size_t count() const;

 private:
  struct OfRobot {
    std::set<std::string> links;                                // all of the robot
    std::map<std::pair<std::string, std::string>, bool> pairs;  // names ascending
    std::set<std::string> disabled_links;                       // by default
  };
  std::vector<OfRobot> robots_;
};

// Holds all rules in force. The first rule that covers a pair decides, in this order:
//   1. a rule of parameters or service that names both bodies; of rules that name a part, or all
//      parts of an object, the most particular one,
//   2. an attached object, or the part of it that is held, with a body that it is attached to,
//   3. a rule of parameters or service with a wildcard,
//   4. the SRDF, for two links, and for a link and a rigid object.
// Without such a rule the pair is not allowed.
struct ContactRules {
  AllowedContacts allowed;
  AttachedObjects attached;
  AttachedObjects ended_holds;  // in force no more, because a newer mesh has other triangles
  LinkRules links;

  // Returns what the rules say of a pair of pieces (BodyParts), in any order of its bodies. Piece 0
  // of a body without parts is all of it.
  ContactVerdict verdict(const BodyStatus& a, const BodyStatus& b, PartId piece_a = 0,
                         PartId piece_b = 0) const;
};

// Returns the pairs of the classes that are on, in ascending order, with allowed ones marked. A
// pair is allowed if all pairs of its parts are.
std::vector<MonitoredPair> monitoredPairs(const std::vector<BodyStatus>& bodies,
                                          const PairClasses& classes, const ContactRules& rules);

// Returns the pairs of each named part of a body in `pairs` with all of the other body, in the
// order of `pairs`.
std::vector<MonitoredPair> monitoredPartPairs(const std::vector<BodyStatus>& bodies,
                                              const std::vector<MonitoredPair>& pairs,
                                              const ContactRules& rules);

// Returns the pairs of pieces that may touch, of the bodies of those `pairs` that are monitored.
std::vector<PartPair> allowedParts(const std::vector<BodyStatus>& bodies,
                                   const std::vector<MonitoredPair>& pairs,
                                   const ContactRules& rules);

}  // namespace deformable_contact_monitor
