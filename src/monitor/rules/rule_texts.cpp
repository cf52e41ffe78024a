// Puts the rules in force into words, for the answers of services and for the diagnostics.
//
// A robot may have thousands of allowed pairs. The diagnostics show counts by source, and per body
// the first few partners.
#include "monitor/rules/rule_texts.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <sstream>

#include "robot/nearest_name.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kShown = 8;  // partners that are named per body

// Collects the bodies that one body may touch, as text.
struct Partners {
  std::string text;
  std::size_t count = 0;

  void add(const std::string& name, RuleSource source) {
    if (++count > kShown) return;
    text += (text.empty() ? "" : ", ") + name + " (" + toString(source) + ")";
  }
};

// Returns "margin 0.01 m (hem 0.05 m), may touch hand (srdf), arm (parameters) and 3 more".
std::string describe(const Body& body, const BodyStatus& status, const Partners& partners) {
  std::ostringstream text;
  text << "margin " << body.own_margin_m << " m";
  const char* before = " (";
  for (std::size_t i = 0; i < status.partCount(); ++i) {
    const auto own = status.parts->margins_m.find(static_cast<PartId>(i + 1));
    if (own == status.parts->margins_m.end()) continue;
    text << before << status.parts->names[i] << " " << own->second << " m";
    before = ", ";
  }
  if (before[0] == ',') text << ")";
  if (partners.count > 0) text << ", may touch " << partners.text;
  if (partners.count > kShown) text << " and " << partners.count - kShown << " more";
  return text.str();
}

// Returns where the rule comes from that decides about a pair. Pieces may have several; the first
// one is as good as any.
RuleSource sourceOf(const std::vector<BodyStatus>& bodies, const MonitoredPair& pair,
                    const ContactRules& rules) {
  const BodyStatus &a = bodies[pair.a], &b = bodies[pair.b];
  return rules.verdict(a, b, piecesOf(a, pair.part_a).front(), piecesOf(b, pair.part_b).front())
      .source;
}

// Adds the parts that may touch, of pairs of bodies that must not: "cloth:hem (parameters)" to the
// other body, and "hand with hem (parameters)" to the cloth.
void addParts(const std::vector<BodyStatus>& bodies, const std::vector<MonitoredPair>& pairs,
              const ContactRules& rules, const std::vector<MonitoredPair>& part_pairs,
              std::vector<Partners>* partners) {
  std::set<std::pair<BodyId, BodyId>> whole;
  for (const MonitoredPair& pair : pairs) {
    if (pair.allowed) whole.emplace(pair.a, pair.b);
  }
  for (const MonitoredPair& pair : part_pairs) {
    if (!pair.allowed || whole.count({pair.a, pair.b}) > 0) continue;
    const RuleSource source = sourceOf(bodies, pair, rules);
    const bool of_a = pair.part_a != 0;
    const BodyId owner = of_a ? pair.a : pair.b, other = of_a ? pair.b : pair.a;
    const PartId part = of_a ? pair.part_a : pair.part_b;
    (*partners)[owner].add(bodies[other].name + " with " + bodies[owner].parts->names[part - 1U],
                           source);
    if (owner != other) (*partners)[other].add(nameOf(bodies[owner], part), source);
  }
}

// Returns the source's index in the arrays of RulesInForce.
std::size_t index(RuleSource source) { return static_cast<std::size_t>(source); }

}  // namespace

// Lists all problems, so that a caller can correct them at once.
std::string attachProblem(const std::string& object, const std::vector<std::string>& links,
                          const MonitorParameters& parameters, const RobotGeometry* robot) {
  std::string problem;
  const auto add = [&problem](const std::string& line) {
    problem += (problem.empty() ? "" : "; ") + line;
  };
  const auto has = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  std::vector<std::string> known, rigids, holders;
  for (const ObjectParameters& other : parameters.objects) known.push_back(other.name);
  for (const RigidParameters& rigid : parameters.rigids) rigids.push_back(rigid.name);
  known.insert(known.end(), rigids.begin(), rigids.end());
  if (!has(known, object)) {
    add("no object '" + object + "' is monitored" + nearestNameHint(object, known));
  }
  if (robot != nullptr) holders.assign(robot->link_names.begin(), robot->link_names.end());
  const bool is_rigid = has(rigids, object);
  if (!is_rigid) holders.insert(holders.end(), rigids.begin(), rigids.end());
  const std::string is_rigid_too =
      "' is rigid as '" + object + "' is, and only links hold rigid objects";
  bool lacks_robot = false;
  for (const std::string& link : links) {
    if (has(holders, link)) continue;
    if (has(rigids, link)) {
      std::string both = "'";
      both += link;
      both += is_rigid_too;
      add(both);
    } else if (robot == nullptr) {
      lacks_robot = true;
    } else {
      add("the robot has no link '" + link + "'" + nearestNameHint(link, holders));
    }
  }
  if (lacks_robot) add("no robot is loaded yet, so no link can hold the object");
  return problem;
}

std::string describeHeld(const std::string& object, const Attachment& attachment) {
  std::string text;
  if (attachment.part != nullptr) {
    const std::size_t count = attachment.part->triangles.size();
    text = std::to_string(count) + (count == 1 ? " triangle of " : " triangles of ");
  }
  text += object + " by ";
  for (std::size_t i = 0; i < attachment.links.size(); ++i) {
    text += (i == 0 ? "" : ", ") + attachment.links[i];
  }
  return text;
}

std::string describeEndedHold(const std::string& object, const Attachment& attachment) {
  return describeHeld(object, attachment) +
         ", because its mesh has other triangles now; attach the object again";
}

std::vector<std::string> describeUnknownNames(const MonitorParameters& parameters,
                                              const AllowedContacts& allowed,
                                              const std::vector<BodyStatus>& bodies) {
  constexpr std::size_t kShown = 20;
  std::set<std::string> known{"*"}, in_rules;
  std::vector<std::string> names, links, lines;
  for (const BodyStatus& body : bodies) {
    known.insert(body.name);
    names.push_back(body.name);
    if (body.kind == BodyKind::kDeformable) {
      known.insert({body.name + ":*", body.name + ":" + kHeldPart});
    }
    for (std::size_t part = 1; part <= body.partCount(); ++part) {
      names.push_back(nameOf(body, static_cast<PartId>(part)));
      known.insert(names.back());
    }
    if (body.kind == BodyKind::kLink) links.push_back(body.name);
  }
  for (const AllowedContact& rule : allowed.rules()) {
    for (const std::string& name : {rule.body_a, rule.body_b}) {
      if (known.count(name) == 0) in_rules.insert(name);
    }
  }
  std::size_t more = 0;
  const auto add = [&](const std::string& where, const std::string& name, const char* what,
                       const std::vector<std::string>& candidates) {
    if (lines.size() == kShown) {
      ++more;
      return;
    }
    lines.push_back(where + " name '" + name + "'" + nearestNameHint(name, candidates) +
                    ", which is no " + what);
  };
  for (const auto& [name, margin_m] : parameters.link_margin_m) {
    if (std::find(links.begin(), links.end(), name) == links.end()) {
      add("margins (~link_margin_m)", name, "link that is looked at", links);
    }
  }
  for (const std::string& name : in_rules) add("allowed contacts", name, "link or object", names);
  if (more > 0) lines.push_back("and " + std::to_string(more) + " more names are unknown");
  return lines;
}

std::string describeHeld(const AttachedObjects& attached) {
  std::string text;
  for (const auto& [object, attachment] : attached) {
    text += (text.empty() ? "held: " : "; ") + describeHeld(object, attachment);
  }
  return text.empty() ? "nothing is held" : text;
}

std::size_t RulesInForce::allowedPairs() const {
  return std::accumulate(allowed_pairs.begin(), allowed_pairs.end(), std::size_t{0});
}

// Asks for the source of each allowed pair again, because the table of pairs does not keep it.
RulesInForce describeRules(const std::vector<BodyStatus>& bodies,
                           const std::vector<MonitoredPair>& pairs, const ContactRules& rules,
                           const Scene& scene, const std::vector<MonitoredPair>& part_pairs) {
  RulesInForce in_force;
  in_force.pairs = pairs.size();
  for (const RuleSource source : {RuleSource::kParameters, RuleSource::kService}) {
    in_force.rules[index(source)] = rules.allowed.count(source);
  }
  in_force.rules[index(RuleSource::kAttached)] = rules.attached.size();
  in_force.rules[index(RuleSource::kSrdf)] = rules.links.count();

  std::vector<Partners> partners(bodies.size());
  for (const MonitoredPair& pair : pairs) {
    if (!pair.allowed) continue;
    const RuleSource source = sourceOf(bodies, pair, rules);
    ++in_force.allowed_pairs[index(source)];
    partners[pair.a].add(bodies[pair.b].name, source);
    if (pair.a != pair.b) partners[pair.b].add(bodies[pair.a].name, source);
  }
  addParts(bodies, pairs, rules, part_pairs, &partners);
  for (BodyId id = 0; id < bodies.size(); ++id) {
    in_force.bodies.emplace_back(bodies[id].name,
                                 describe(scene.body(id), bodies[id], partners[id]));
  }
  for (const auto& [object, attachment] : rules.attached) {
    in_force.attached.push_back(describeHeld(object, attachment));
  }
  for (const auto& [object, attachment] : rules.ended_holds) {
    in_force.ended_holds.push_back(describeEndedHold(object, attachment));
  }
  return in_force;
}

}  // namespace deformable_contact_monitor
