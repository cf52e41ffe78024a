// Checks a robot, from whatever source, before it is monitored, and describes its links. All
// functions are pure.
#pragma once

#include <string>
#include <vector>

#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Returns the robot with only the links that the options select, in order. Throws
// std::runtime_error if a link occurs twice, or if a link that `options.links` names is missing.
RobotGeometry selectedLinks(RobotGeometry robot, const RobotGeometryOptions& options);

// Returns the robot's links without their shapes, because newer link meshes had this problem.
RobotGeometry withoutShapes(RobotGeometry robot, const std::string& problem);

// Returns whether withoutShapes() made the robot.
bool isWithoutShapes(const RobotGeometry& robot);

// Returns the names that no link has, with hints: "'hnad' (did you mean 'hand'?), 'arm'". Returns
// an empty text if every name is a link's.
std::string namesOfNoLink(const std::vector<std::string>& names, const RobotGeometry& robot);

// Sets the robots of link meshes that came without a URDF: a link belongs to the robot with the
// longest link_prefix that its name begins with. `srdfs` has one SRDF for each of `parameters`.
void setSrdfs(const std::vector<RobotParameters>& parameters, const std::vector<Srdf>& srdfs,
              RobotGeometry* robot);

// Throws std::runtime_error if a link has no name or that of an object, or if strict_geometry is on
// and links have no usable geometry. The text lists all of these.
void checkRobot(const RobotGeometry& robot, const MonitorParameters& parameters);

// Returns what a user should know about a robot that is used, a line each: links without usable
// geometry, unusual sizes and numbers of triangles, and names in its SRDF that no link has.
std::vector<std::string> robotWarnings(const RobotGeometry& robot,
                                       const MonitorParameters& parameters);

// Returns a line that names the ignored links that were not sent; empty: there are none.
std::string ignoredLinksWarning(const RobotGeometry& sent, const RobotGeometryOptions& options);

// Returns "link 'hand': 12 triangles, 0.2 m long, margin 0.01 m, from box ...". For a link without
// usable geometry, returns why, and that the link is UNKNOWN.
std::string describeLink(const LinkGeometry& link, const MonitorParameters& parameters);

}  // namespace deformable_contact_monitor
