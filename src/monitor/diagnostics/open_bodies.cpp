// Bodies that are not closed, so that nothing is said to be within some of their parts.
#include "monitor/diagnostics/open_bodies.h"

namespace deformable_contact_monitor {

std::vector<std::string> OpenBodies::look(const CycleReport& report) {
  std::vector<std::string> to_say;
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const Containment::Components& parts = report.containment->bodies.at(id);
    if (!parts.looked_at) continue;
    const std::string& body = report.bodies[id].name;
    open_.erase(body);
    if (parts.open == 0) continue;
    const std::string count =
        std::to_string(parts.open) + " of " + std::to_string(parts.all) + " parts";
    open_[body] = count;
    if (!said_.insert(body).second) continue;
    to_say.push_back("containment: " + count + " of '" + body +
                     "' are not closed: nothing is said to be within those");
  }
  return to_say;
}

std::string OpenBodies::list() const {
  std::string all;
  for (const auto& [body, count] : open_) {
    all += (all.empty() ? "" : ", ") + body + " (" + count + ")";
  }
  return all;
}

}  // namespace deformable_contact_monitor
