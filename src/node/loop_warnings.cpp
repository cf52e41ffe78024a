// What people are told when the detection loop cannot do what they want.
#include "node/loop_warnings.h"

#include <algorithm>
#include <set>

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
  std::set<std::string> known{"*"}, unknown;
  for (const BodyStatus& body : bodies) known.insert(body.name);
  for (const AllowedContact& rule : allowed.rules()) {
    for (const std::string& name : {rule.body_a, rule.body_b}) {
      if (known.count(name) == 0) unknown.insert(name);
    }
  }
  return {unknown.begin(), unknown.end()};
}

}  // namespace deformable_contact_monitor
