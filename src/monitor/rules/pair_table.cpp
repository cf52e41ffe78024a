// Which pairs of bodies are monitored, and which of them are allowed to touch.
#include "monitor/rules/pair_table.h"

namespace deformable_contact_monitor {
namespace {

bool isMonitored(const BodyStatus& a, const BodyStatus& b, bool same, const PairClasses& classes) {
  const int objects = (a.kind == BodyKind::kDeformable) + (b.kind == BodyKind::kDeformable);
  if (same) return objects == 2 && classes.deformable_self;
  if (objects == 2) return classes.deformable_deformable;
  return objects == 1 ? classes.robot_deformable : classes.robot_self;
}

}  // namespace

std::vector<std::string> namesOf(const PairClasses& classes) {
  std::vector<std::string> names;
  if (classes.robot_deformable) names.emplace_back("robot_deformable");
  if (classes.deformable_deformable) names.emplace_back("deformable_deformable");
  if (classes.deformable_self) names.emplace_back("deformable_self");
  if (classes.robot_self) names.emplace_back("robot_self");
  return names;
}

std::vector<MonitoredPair> monitoredPairs(const std::vector<BodyStatus>& bodies,
                                          const PairClasses& classes, const ContactRules& rules) {
  std::vector<MonitoredPair> pairs;
  for (BodyId a = 0; a < bodies.size(); ++a) {
    for (BodyId b = a; b < bodies.size(); ++b) {
      if (!isMonitored(bodies[a], bodies[b], a == b, classes)) continue;
      pairs.push_back({a, b, rules.verdict(bodies[a], bodies[b]).allowed});
    }
  }
  return pairs;
}

}  // namespace deformable_contact_monitor
