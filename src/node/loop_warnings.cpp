// What people are told when the detection loop cannot do what they want.
#include "node/loop_warnings.h"

#include <algorithm>

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

std::vector<std::string> unknownNames(const AllowedContacts& allowed,
                                      const std::vector<BodyStatus>& bodies) {
  std::vector<std::string> unknown;
  for (const AllowedContact& rule : allowed.rules()) {
    for (const std::string& name : {rule.body_a, rule.body_b}) {
      const auto is_it = [&name](const BodyStatus& body) { return body.name == name; };
      if (name == "*" || std::any_of(bodies.begin(), bodies.end(), is_it)) continue;
      unknown.push_back(name);
    }
  }
  return unknown;
}

}  // namespace deformable_contact_monitor
