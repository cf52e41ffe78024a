// Bodies that are not closed, so that nothing is said to be within some of their parts.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// One thread at a time.
class OpenBodies {
 public:
  // After a cycle with `containment`: what is to be said, once for each body.
  std::vector<std::string> look(const CycleReport& report);

  // Those that are open as they were last looked at: "<body> (1 of 2 parts)", by commas.
  std::string list() const;

 private:
  std::map<std::string, std::string> open_;  // "1 of 2 parts", by body
  std::set<std::string> said_;
};

}  // namespace deformable_contact_monitor
