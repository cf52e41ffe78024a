// What a robot from any source must be like before it is monitored.
#pragma once

#include <string>
#include <vector>

#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Keeps the links that the options ask for, in order. Throws std::runtime_error if a link is there
// twice, or one that `options.links` names is not there.
RobotGeometry selectedLinks(RobotGeometry robot, const RobotGeometryOptions& options);

// "'hnad' (did you mean 'hand'?), 'arm'": those of the names that are no link's; empty: none.
std::string namesOfNoLink(const std::vector<std::string>& names, const RobotGeometry& robot);

// Throws std::runtime_error if a link has an object's name or, with strict_geometry, a problem.
void checkRobot(const RobotGeometry& robot, const MonitorParameters& parameters);

// "link 'hand': 12 triangles, 0.2 m long, margin 0.01 m, from box ..."; of one without usable
// geometry: why, and that it is UNKNOWN.
std::string describeLink(const LinkGeometry& link, const MonitorParameters& parameters);

}  // namespace deformable_contact_monitor
