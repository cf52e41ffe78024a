// Puts the rules in force into words, for the answers of services, the diagnostics and warnings.
// contact_rules.h decides; this file only describes. All functions are pure.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/scene.h"
#include "monitor/cycle_report.h"
#include "monitor/rules/contact_rules.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Returns why the object cannot be attached to these links, empty if it can. The text lists every
// unknown name with the nearest known one. Any link of the robot will do, also one without
// geometry, and a rigid object may hold one that deforms; an empty list of links releases the
// object. `robot` is null while there is no robot.
std::string attachProblem(const std::string& object, const std::vector<std::string>& links,
                          const MonitorParameters& parameters, const RobotGeometry* robot);

// Returns a warning for each name in the rules and in the parameters' link_margin_m that no body
// has, with the most similar name. Lists the first few names, and counts the others.
std::vector<std::string> describeUnknownNames(const MonitorParameters& parameters,
                                              const AllowedContacts& allowed,
                                              const std::vector<BodyStatus>& bodies);

// Returns "held: cloth by hand, finger; cable by hand", or "nothing is held".
std::string describeHeld(const AttachedObjects& attached);

// Returns "cloth by hand, finger", or "12 triangles of cloth by hand, finger".
std::string describeHeld(const std::string& object, const Attachment& attachment);

// Returns the same of a hold that has ended, with the reason.
std::string describeEndedHold(const std::string& object, const Attachment& attachment);

// The rules in force, as the status `allowed` of the diagnostics shows them.
struct RulesInForce {
  std::size_t pairs = 0;                       // monitored
  std::array<std::size_t, 5> allowed_pairs{};  // those of `pairs`, by RuleSource
  std::array<std::size_t, 5> rules{};          // by RuleSource
  std::vector<std::string> attached;           // "cloth by hand, finger"
  std::vector<std::string> ended_holds;        // since the last ~attach_object, in words
  std::vector<std::pair<std::string, std::string>> bodies;  // name; margin and allowed partners

  // Returns how many pairs may touch, over all sources.
  std::size_t allowedPairs() const;
};

// Describes margins and rules of every body. Names only the first few partners of a body that may
// touch many. Parts of objects are named where the object as a whole must not touch. `bodies`,
// `pairs`, `part_pairs` and `scene` must use the same BodyIds.
RulesInForce describeRules(const std::vector<BodyStatus>& bodies,
                           const std::vector<MonitoredPair>& pairs, const ContactRules& rules,
                           const Scene& scene, const std::vector<MonitoredPair>& part_pairs = {});

}  // namespace deformable_contact_monitor
