// Margins and rules that hold, in words.
#include "monitor/rules/rules_in_force.h"

#include <numeric>
#include <sstream>

#include "monitor/rules/attach_object.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kShown = 8;  // of those that a body may touch

struct Partners {
  std::string text;
  std::size_t count = 0;

  void add(const std::string& name, RuleSource source) {
    if (++count > kShown) return;
    text += (text.empty() ? "" : ", ") + name + " (" + toString(source) + ")";
  }
};

std::string describe(double margin_m, const Partners& partners) {
  std::ostringstream text;
  text << "margin " << margin_m << " m";
  if (partners.count > 0) text << ", may touch " << partners.text;
  if (partners.count > kShown) text << " and " << partners.count - kShown << " more";
  return text.str();
}

std::size_t index(RuleSource source) { return static_cast<std::size_t>(source); }

}  // namespace

std::size_t RulesInForce::allowedPairs() const {
  return std::accumulate(allowed_pairs.begin(), allowed_pairs.end(), std::size_t{0});
}

RulesInForce describeRules(const std::vector<BodyStatus>& bodies,
                           const std::vector<MonitoredPair>& pairs, const ContactRules& rules,
                           const Scene& scene) {
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
    const RuleSource source = rules.verdict(bodies[pair.a], bodies[pair.b]).source;
    ++in_force.allowed_pairs[index(source)];
    partners[pair.a].add(bodies[pair.b].name, source);
    if (pair.a != pair.b) partners[pair.b].add(bodies[pair.a].name, source);
  }
  for (BodyId id = 0; id < bodies.size(); ++id) {
    in_force.bodies.emplace_back(bodies[id].name, describe(scene.body(id).margin_m, partners[id]));
  }
  for (const auto& [object, links] : rules.attached) {
    in_force.attached.push_back(describeHeld(object, links));
  }
  return in_force;
}

}  // namespace deformable_contact_monitor
