// What ~attach_object refuses and answers.
#include "monitor/rules/attach_object.h"

#include <algorithm>

#include "robot/nearest_name.h"

namespace deformable_contact_monitor {

std::string attachProblem(const std::string& object, const std::vector<std::string>& links,
                          const std::vector<ObjectParameters>& objects,
                          const RobotGeometry* robot) {
  std::string problem;
  const auto add = [&problem](const std::string& line) {
    problem += (problem.empty() ? "" : "; ") + line;
  };
  std::vector<std::string> known;
  for (const ObjectParameters& other : objects) known.push_back(other.name);
  if (std::find(known.begin(), known.end(), object) == known.end()) {
    add("no object '" + object + "' is monitored" + nearestNameHint(object, known));
  }
  if (links.empty()) return problem;
  if (robot == nullptr) {
    add("there is no robot");
    return problem;
  }
  known.assign(robot->link_names.begin(), robot->link_names.end());
  for (const std::string& link : links) {
    if (robot->link_names.count(link) > 0) continue;
    add("the robot has no link '" + link + "'" + nearestNameHint(link, known));
  }
  return problem;
}

std::string describeHeld(const std::string& object, const std::vector<std::string>& links) {
  std::string text = object + " by ";
  for (std::size_t i = 0; i < links.size(); ++i) text += (i == 0 ? "" : ", ") + links[i];
  return text;
}

std::string describeHeld(const AttachedObjects& attached) {
  std::string text;
  for (const auto& [object, links] : attached) {
    text += (text.empty() ? "held: " : "; ") + describeHeld(object, links);
  }
  return text.empty() ? "nothing is held" : text;
}

}  // namespace deformable_contact_monitor
