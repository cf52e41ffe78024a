// What people are told when the detection loop cannot do what they want.
#include "monitor/cycle/loop_warnings.h"

#include <algorithm>
#include <set>

#include "robot/nearest_name.h"

namespace deformable_contact_monitor {

std::string describeMisses(const TransformReport& transforms) {
  constexpr std::size_t kShown = 5;
  const std::vector<TransformReport::Miss>& misses = transforms.misses;
  std::string text = "UNKNOWN for want of a transform:";
  for (std::size_t i = 0; i < std::min(kShown, misses.size()); ++i) {
    text += "\n  " + misses[i].body + ": " + misses[i].answer.problem;
  }
  if (misses.size() > kShown) {
    text += "\n  and " + std::to_string(misses.size() - kShown) + " more";
  }
  return text;
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

}  // namespace deformable_contact_monitor
