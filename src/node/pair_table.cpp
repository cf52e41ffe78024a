// Which pairs of bodies are monitored, and which of them are allowed to touch.
#include "node/pair_table.h"

#include <algorithm>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

constexpr char kAnyBody[] = "*";

bool matches(const std::string& name, const std::string& body) {
  return name == kAnyBody || name == body;
}

bool sameNames(const AllowedContact& r, const AllowedContact& s) {
  return (r.body_a == s.body_a && r.body_b == s.body_b) ||
         (r.body_a == s.body_b && r.body_b == s.body_a);
}

bool isMonitored(const BodyStatus& a, const BodyStatus& b, bool same, const PairClasses& classes) {
  const int objects = (a.kind == BodyKind::kDeformable) + (b.kind == BodyKind::kDeformable);
  if (same) return objects == 2 && classes.deformable_self;
  if (objects == 2) return classes.deformable_deformable;
  return objects == 1 ? classes.robot_deformable : classes.robot_self;
}

}  // namespace

void AllowedContacts::add(const AllowedContact& rule) {
  if (rule.body_a.empty() || rule.body_b.empty()) {
    throw std::invalid_argument(
        "an allowed contact needs both body_a and body_b (a name, or '*' for any body)");
  }
  rules_.erase(std::remove_if(rules_.begin(), rules_.end(),
                              [&rule](const AllowedContact& r) { return sameNames(r, rule); }),
               rules_.end());
  rules_.push_back(rule);
}

bool AllowedContacts::allows(const std::string& a, const std::string& b) const {
  bool allowed = false;
  int fewest_wildcards = 3;
  for (const AllowedContact& rule : rules_) {
    const bool applies = (matches(rule.body_a, a) && matches(rule.body_b, b)) ||
                         (matches(rule.body_a, b) && matches(rule.body_b, a));
    const int wildcards = (rule.body_a == kAnyBody) + (rule.body_b == kAnyBody);
    if (!applies || wildcards > fewest_wildcards) continue;
    fewest_wildcards = wildcards;
    allowed = rule.allowed;
  }
  return allowed;
}

std::vector<MonitoredPair> monitoredPairs(const std::vector<BodyStatus>& bodies,
                                          const PairClasses& classes,
                                          const AllowedContacts& allowed) {
  std::vector<MonitoredPair> pairs;
  for (BodyId a = 0; a < bodies.size(); ++a) {
    for (BodyId b = a; b < bodies.size(); ++b) {
      if (!isMonitored(bodies[a], bodies[b], a == b, classes)) continue;
      pairs.push_back({a, b, allowed.allows(bodies[a].name, bodies[b].name)});
    }
  }
  return pairs;
}

}  // namespace deformable_contact_monitor
