// What ~attach_object refuses and answers.
#pragma once

#include <string>
#include <vector>

#include "monitor/cycle_report.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Why these links cannot hold the object, all unknown names with the nearest known ones; empty:
// they can. Any link of the robot (null: there is none) may hold, also one that is not looked at.
// None at all release the object.
std::string attachProblem(const std::string& object, const std::vector<std::string>& links,
                          const std::vector<ObjectParameters>& objects, const RobotGeometry* robot);

// "held: cloth by hand, finger; cable by hand", "nothing is held".
std::string describeHeld(const AttachedObjects& attached);

// "cloth by hand, finger".
std::string describeHeld(const std::string& object, const std::vector<std::string>& links);

}  // namespace deformable_contact_monitor
