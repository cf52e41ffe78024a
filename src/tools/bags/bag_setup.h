// Sets up the cycles of bags: the configuration, the robot, and an object that is not in the bags.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"
#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_cycles.h"
#include "tools/bags/bag_reader.h"
#include "tools/common/bag_files.h"
#include "tools/simulation/scene_object.h"

namespace deformable_contact_monitor {

// Everything that BagCycles is made with.
struct BagSetup {
  MonitorParameters parameters;
  // There is at least one. It has no links if no robot is needed.
  History<RobotGeometry> robots;
  std::string robot_from;  // where the robots come from, for people
  std::optional<PlayedObject> played;
};

// Reads the parameters of the configuration file; without a file, returns the defaults. The
// options' frame prefix and topics of objects replace those of the file. `warn` gets unknown names.
// Throws std::runtime_error, one line, if the file is invalid, or if two objects have one topic.
MonitorParameters readBagParameters(const BagFiles& files,
                                    const std::function<void(const std::string&)>& warn);

// Returns the messages that cycles with these parameters need. Types that cameras send too, such as
// point clouds, are read only on the topics of objects.
BagSelection neededMessages(const MonitorParameters& parameters, const BagFiles& files);

// Sets up the cycles. `configured` comes from readBagParameters(). Without a configuration file:
// - the objects are the topics of deformable meshes, named by their messages or by the topic;
// - the reference frame is the root link of a robot from a URDF, or base_link, or the root of the
//   transforms if they do not know that.
// `contents` gets the frames that joint states and the URDF give. `object` is played if it
// isWanted(). `warn` gets what a user should know, a line each. Throws std::exception, one line, if
// the cycles would make no sense: no mesh, no robot, a bad value.
BagSetup setUpBags(const BagFiles& files, const MonitorParameters& configured,
                   const SceneObject& object, BagContents* contents,
                   const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
