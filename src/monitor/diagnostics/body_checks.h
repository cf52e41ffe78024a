// Finds bodies whose meshes are probably not what the user meant: surfaces that are not closed,
// and sizes or distances that suggest another unit.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/steady_time.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// Lists bodies with parts that are not closed. Containment reports nothing as inside of such parts.
// Not safe for use by several threads.
class OpenBodies {
 public:
  // Takes a cycle whose report has a `containment`. Returns one line to log for each body that is
  // open and was not reported before.
  std::vector<std::string> look(const CycleReport& report);

  // Returns the bodies that were open when last examined: "base (1 of 2 parts), cloth (...)".
  std::string list() const;

 private:
  std::map<std::string, std::string> open_;  // "1 of 2 parts", by body
  std::set<std::string> reported_;
};

// Checks the size and the place of deformable objects. A mesh in millimetres, for example, is 1000
// times too large. Not safe for use by several threads. Reads no clock.
class SizeCheck {
 public:
  // An object's name and what is anomalous about it; empty: nothing.
  using Finding = std::pair<std::string, std::string>;

  // Examines the objects that triggered the cycle, each at most once a second, and compares them
  // with the links that have a pose in it. An object is anomalous if it is more than 100 times as
  // large as the robot, or as far away, which is not examined without such a link, or if none of
  // its vertices is finite.
  std::vector<Finding> look(const CycleReport& report, SteadyTime now);

 private:
  std::map<std::string, SteadyTime> due_;  // by object
};

}  // namespace deformable_contact_monitor
