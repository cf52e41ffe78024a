// Which pairs of bodies are monitored, and which of them are allowed to touch.
#include "node/pair_table.h"

#include <algorithm>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

constexpr char kAnyBody[] = "*";

bool isMonitored(const BodyStatus& a, const BodyStatus& b, bool same, const PairClasses& classes) {
  const int objects = (a.kind == BodyKind::kDeformable) + (b.kind == BodyKind::kDeformable);
  if (same) return objects == 2 && classes.deformable_self;
  if (objects == 2) return classes.deformable_deformable;
  return objects == 1 ? classes.robot_deformable : classes.robot_self;
}

}  // namespace

AllowedContacts::Names AllowedContacts::namesOf(const AllowedContact& rule) {
  if (rule.body_a.empty() || rule.body_b.empty()) {
    throw std::invalid_argument(
        "an allowed contact needs both body_a and body_b (a name, or '*' for any body)");
  }
  return std::minmax(rule.body_a, rule.body_b);
}

void AllowedContacts::add(const AllowedContact& rule) {
  Names names = namesOf(rule);
  if (rules_.size() >= kMostRules && rules_.count(names) == 0) {
    throw std::invalid_argument("there are " + std::to_string(kMostRules) +
                                " rules of allowed contacts, which is the most; use '*'");
  }
  rules_[std::move(names)] = {rule, ++added_};
}

void AllowedContacts::change(const AllowedContactsChange& change) {
  AllowedContacts changed = change.replace ? AllowedContacts() : *this;
  for (const AllowedContact& rule : change.remove) {
    if (changed.rules_.erase(namesOf(rule)) == 0) {
      throw std::invalid_argument("no rule for '" + rule.body_a + "' and '" + rule.body_b +
                                  "' is in force, to be removed");
    }
  }
  for (const AllowedContact& rule : change.add) changed.add(rule);
  *this = std::move(changed);
}

const AllowedContacts::Rule* AllowedContacts::find(const std::string& a,
                                                   const std::string& b) const {
  const auto found = rules_.find(std::minmax(a, b));
  return found == rules_.end() ? nullptr : &found->second;
}

bool AllowedContacts::allows(const std::string& a, const std::string& b) const {
  if (const Rule* const both = find(a, b)) return both->rule.allowed;
  const Rule *const first = find(a, kAnyBody), *const second = find(b, kAnyBody);
  if (first != nullptr && (second == nullptr || first->added > second->added)) {
    return first->rule.allowed;
  }
  if (second != nullptr) return second->rule.allowed;
  const Rule* const any = find(kAnyBody, kAnyBody);
  return any != nullptr && any->rule.allowed;
}

std::vector<AllowedContact> AllowedContacts::rules() const {
  std::vector<const Rule*> in_order;
  in_order.reserve(rules_.size());
  for (const auto& [names, rule] : rules_) in_order.push_back(&rule);
  std::sort(in_order.begin(), in_order.end(),
            [](const Rule* a, const Rule* b) { return a->added < b->added; });
  std::vector<AllowedContact> rules;
  rules.reserve(in_order.size());
  for (const Rule* rule : in_order) rules.push_back(rule->rule);
  return rules;
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
