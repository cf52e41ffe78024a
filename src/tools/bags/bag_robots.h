// Loads the robots of recorded cycles: their links, their SRDFs and their joint states.
#pragma once

#include <functional>
#include <string>

#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"
#include "tools/bags/bag_contents.h"
#include "tools/common/bag_files.h"

namespace deformable_contact_monitor {

// Loads the robots from the option's URDF, the bags' link meshes or the bags' URDFs, in this order,
// with the SRDFs that the option names, or the configuration, or else those in the bags. The result
// is not empty. `from` becomes where they come from, for people. `warn` gets what a user should
// know, a line each. Throws std::exception, one line, if there is no robot that can be used.
History<RobotGeometry> loadBagRobots(const BagFiles& files, const MonitorParameters& parameters,
                                     const BagContents& contents, std::string* from,
                                     const std::function<void(const std::string&)>& warn);

// Returns the index of the first of these robots whose links have shapes; 0 if there is none.
// Others stand for link meshes that were rejected.
std::size_t firstWithShapes(const History<RobotGeometry>& robots);

// Adds the frames that joint states and the URDF give and TF does not have to `contents`. Does
// nothing for the parameter `robots`: robots of one URDF have joints of the same names.
void useJointStates(const BagFiles& files, const MonitorParameters& parameters,
                    BagContents* contents, const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
