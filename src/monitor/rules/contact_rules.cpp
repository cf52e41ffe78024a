// Decides which pairs of bodies are monitored and which of them may touch.
//
// Rules are kept in maps by their two names in ascending order, so that a look-up does not depend
// on the order of bodies and stays fast with 100 000 rules.
#include "monitor/rules/contact_rules.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

constexpr char kAnyBody[] = "*";  // the wildcard of AllowedContact

// Returns whether this piece of the object is attached to the other body.
bool isAttached(const AttachedObjects& attached, const BodyStatus& object, PartId piece,
                const BodyStatus& holder) {
  if (object.kind == BodyKind::kLink || holder.kind == BodyKind::kDeformable) return false;
  const auto found = attached.find(object.name);
  if (found == attached.end()) return false;
  const std::vector<std::string>& links = found->second.links;
  const std::shared_ptr<const HeldPart>& part = found->second.part;
  if (std::find(links.begin(), links.end(), holder.name) == links.end()) return false;
  return part == nullptr || (object.parts != nullptr && object.parts->isHeld(piece));
}

// Returns whether a class that is on includes the pair. `same`: the pair is a body with itself; a
// link with itself is never monitored, and neither are two rigid objects.
bool isMonitored(const BodyStatus& a, const BodyStatus& b, bool same, const PairClasses& classes) {
  const int objects = (a.kind == BodyKind::kDeformable) + (b.kind == BodyKind::kDeformable);
  const int rigids = (a.kind == BodyKind::kRigid) + (b.kind == BodyKind::kRigid);
  if (same) return objects == 2 && classes.deformable_self;
  if (rigids == 1) return objects == 1 ? classes.deformable_rigid : classes.robot_rigid;
  if (rigids == 2) return false;
  if (objects == 2) return classes.deformable_deformable;
  return objects == 1 ? classes.robot_deformable : classes.robot_self;
}

// Returns the names by which rules may mean a piece, from the least to the most particular one.
AllowedContacts::RuleNames ruleNames(const BodyStatus& body, PartId piece) {
  if (piece == 0) return {body.name};
  AllowedContacts::RuleNames names = {body.name, body.name + ":*"};
  for (std::size_t part = 1; part <= body.partCount(); ++part) {
    const auto id = static_cast<PartId>(part);
    if (body.parts->has(id, piece)) names.push_back(nameOf(body, id));
  }
  return names;
}

// Returns whether all of a part of one body, and of a part of the other, may touch.
bool areAllowed(const BodyStatus& a, PartId part_a, const BodyStatus& b, PartId part_b,
                const ContactRules& rules) {
  const std::vector<PartId> of_b = piecesOf(b, part_b);
  for (const PartId piece_a : piecesOf(a, part_a)) {
    for (const PartId piece_b : of_b) {
      if (!rules.verdict(a, b, piece_a, piece_b).allowed) return false;
    }
  }
  return true;
}

}  // namespace

bool PairClasses::operator==(const PairClasses& other) const {
  return namesOf(*this) == namesOf(other);
}

std::vector<std::string> namesOf(const PairClasses& classes) {
  std::vector<std::string> names;
  for (const NamedPairClass& one : kPairClasses) {
    if (classes.*one.is_on) names.emplace_back(one.name);
  }
  return names;
}

const char* toString(RuleSource source) {
  constexpr const char* kNames[] = {"default", "parameters", "service", "attached", "srdf"};
  return kNames[static_cast<std::size_t>(source)];
}

// Returns the key of a rule.
AllowedContacts::Names AllowedContacts::namesOf(const AllowedContact& rule) {
  if (rule.body_a.empty() || rule.body_b.empty()) {
    throw std::invalid_argument(
        "an allowed contact needs both body_a and body_b (a name, or '*' for any body)");
  }
  return std::minmax(rule.body_a, rule.body_b);
}

// A rule that replaces another one counts as the last one added.
void AllowedContacts::add(const AllowedContact& rule, RuleSource source) {
  Names names = namesOf(rule);
  if (rules_.size() >= kMostRules && rules_.count(names) == 0) {
    throw std::invalid_argument("there are " + std::to_string(kMostRules) +
                                " rules of allowed contacts, and no more are possible; use "
                                "wildcards ('*')");
  }
  rules_[std::move(names)] = {rule, source, ++added_};
}

// Works on a copy, so that an exception leaves the rules as they were.
void AllowedContacts::change(const AllowedContactsChange& change) {
  AllowedContacts changed = change.replace ? AllowedContacts() : *this;
  for (const AllowedContact& rule : change.remove) {
    if (changed.rules_.erase(namesOf(rule)) == 0) {
      throw std::invalid_argument("the rule for '" + rule.body_a + "' and '" + rule.body_b +
                                  "' cannot be removed, because no such rule is in force");
    }
  }
  for (const AllowedContact& rule : change.add) changed.add(rule, RuleSource::kService);
  *this = std::move(changed);
}

// Returns null if there is no rule for exactly these names.
const AllowedContacts::Rule* AllowedContacts::find(const std::string& a,
                                                   const std::string& b) const {
  const auto found = rules_.find(std::minmax(a, b));
  return found == rules_.end() ? nullptr : &found->second;
}

// The rank of a rule grows with how particular its two names are. All names of parts are alike.
AllowedContacts::Ranked AllowedContacts::findBest(const RuleNames& a, const RuleNames& b) const {
  constexpr std::size_t kRankOfPart = 2;
  Ranked best;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      const Ranked found{find(a[i], b[j]), std::min(i, kRankOfPart) + std::min(j, kRankOfPart)};
      if (found.beats(best)) best = found;
    }
  }
  return best;
}

bool AllowedContacts::Ranked::beats(const Ranked& other) const {
  if (rule == nullptr || other.rule == nullptr) return rule != nullptr;
  return rank != other.rank ? rank > other.rank : rule->added > other.rule->added;
}

std::optional<ContactVerdict> AllowedContacts::ofPair(const RuleNames& a,
                                                      const RuleNames& b) const {
  const Ranked best = findBest(a, b);
  return best.rule == nullptr ? std::nullopt : std::optional(best.rule->verdict());
}

// A rule with one wildcard can name either body.
std::optional<ContactVerdict> AllowedContacts::ofWildcard(const RuleNames& a,
                                                          const RuleNames& b) const {
  Ranked best = findBest(a, {kAnyBody});
  const Ranked other = findBest(b, {kAnyBody});
  if (other.beats(best)) best = other;
  if (best.rule == nullptr) best.rule = find(kAnyBody, kAnyBody);
  return best.rule == nullptr ? std::nullopt : std::optional(best.rule->verdict());
}

bool AllowedContacts::allows(const std::string& a, const std::string& b) const {
  if (const auto pair = ofPair({a}, {b})) return pair->allowed;
  return ofWildcard({a}, {b}).value_or(ContactVerdict()).allowed;
}

std::size_t AllowedContacts::count(RuleSource source) const {
  return static_cast<std::size_t>(
      std::count_if(rules_.begin(), rules_.end(),
                    [source](const auto& entry) { return entry.second.source == source; }));
}

// Sorts pointers, because moving the rules with their texts would take longer.
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

// An SRDF may list a pair as disabled and enabled. Disabled wins, so it is written last.
LinkRules::LinkRules(const std::vector<DescribedRobot>& robots) {
  for (const DescribedRobot& robot : robots) {
    OfRobot rules{robot.links, {}, robot.srdf.disabled_links};
    for (const Srdf::Pair& p : robot.srdf.enabled) rules.pairs[std::minmax(p.a, p.b)] = false;
    for (const Srdf::Pair& p : robot.srdf.disabled) rules.pairs[std::minmax(p.a, p.b)] = true;
    robots_.push_back(std::move(rules));
  }
}

// A rule for the pair beats what the SRDF says about all pairs of a link.
bool LinkRules::allows(const BodyStatus& a, const BodyStatus& b) const {
  const auto is_others = [](const BodyStatus& body, const OfRobot& robot) {
    return body.kind == BodyKind::kLink && robot.links.count(body.name) == 0;
  };
  for (const OfRobot& robot : robots_) {
    if (is_others(a, robot) || is_others(b, robot)) continue;
    const auto pair = robot.pairs.find(std::minmax(a.name, b.name));
    if (pair != robot.pairs.end()) return pair->second;
    return robot.disabled_links.count(a.name) > 0 || robot.disabled_links.count(b.name) > 0;
  }
  return false;
}

std::size_t LinkRules::count() const {
  std::size_t sum = 0;
  for (const OfRobot& robot : robots_) sum += robot.pairs.size() + robot.disabled_links.size();
  return sum;
}

// Asks the sources in the order of their strength; the first that covers the pair decides.
ContactVerdict ContactRules::verdict(const BodyStatus& a, const BodyStatus& b, PartId piece_a,
                                     PartId piece_b) const {
  const auto names_a = ruleNames(a, piece_a), names_b = ruleNames(b, piece_b);
  if (const auto pair = allowed.ofPair(names_a, names_b)) return *pair;
  if (isAttached(attached, a, piece_a, b) || isAttached(attached, b, piece_b, a)) {
    return {true, RuleSource::kAttached};
  }
  if (const auto wildcard = allowed.ofWildcard(names_a, names_b)) return *wildcard;
  const bool deforms = a.kind == BodyKind::kDeformable || b.kind == BodyKind::kDeformable;
  if (!deforms && links.allows(a, b)) return {true, RuleSource::kSrdf};
  return {};
}

// Takes all pairs, also those that are allowed: they are monitored, but not computed.
std::vector<MonitoredPair> monitoredPairs(const std::vector<BodyStatus>& bodies,
                                          const PairClasses& classes, const ContactRules& rules) {
  std::vector<MonitoredPair> pairs;
  for (BodyId a = 0; a < bodies.size(); ++a) {
    for (BodyId b = a; b < bodies.size(); ++b) {
      if (!isMonitored(bodies[a], bodies[b], a == b, classes)) continue;
      pairs.push_back({a, b, areAllowed(bodies[a], 0, bodies[b], 0, rules)});
    }
  }
  return pairs;
}

std::vector<MonitoredPair> monitoredPartPairs(const std::vector<BodyStatus>& bodies,
                                              const std::vector<MonitoredPair>& pairs,
                                              const ContactRules& rules) {
  std::vector<MonitoredPair> part_pairs;
  const auto add = [&](const MonitoredPair& pair, PartId part_a, PartId part_b) {
    const bool allowed = areAllowed(bodies[pair.a], part_a, bodies[pair.b], part_b, rules);
    part_pairs.push_back({pair.a, pair.b, allowed, part_a, part_b});
  };
  for (const MonitoredPair& pair : pairs) {
    const std::size_t of_a = pair.a == pair.b ? 0 : bodies[pair.a].partCount();
    for (std::size_t part = 1; part <= of_a; ++part) add(pair, static_cast<PartId>(part), 0);
    for (std::size_t part = 1; part <= bodies[pair.b].partCount(); ++part) {
      add(pair, 0, static_cast<PartId>(part));
    }
  }
  return part_pairs;
}

std::vector<PartPair> allowedParts(const std::vector<BodyStatus>& bodies,
                                   const std::vector<MonitoredPair>& pairs,
                                   const ContactRules& rules) {
  std::vector<PartPair> allowed;
  for (const MonitoredPair& pair : pairs) {
    const BodyStatus &a = bodies[pair.a], &b = bodies[pair.b];
    if (pair.allowed || a.partCount() + b.partCount() == 0) continue;
    for (std::size_t i = 0; i < a.pieceCount(); ++i) {
      for (std::size_t j = pair.a == pair.b ? i : 0; j < b.pieceCount(); ++j) {
        const auto piece_a = static_cast<PartId>(i), piece_b = static_cast<PartId>(j);
        if (!rules.verdict(a, b, piece_a, piece_b).allowed) continue;
        allowed.push_back({pair.a, pair.b, piece_a, piece_b});
      }
    }
  }
  return allowed;
}

}  // namespace deformable_contact_monitor
