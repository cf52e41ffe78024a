// What the bags' cycles are made with: the configuration, the robot, and an object that is not in
// the bags.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"
#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_cycles.h"
#include "tools/bags/bag_files.h"
#include "tools/bags/bag_reader.h"
#include "tools/common/scene_object.h"

namespace deformable_contact_monitor {

struct BagSetup {
  MonitorParameters parameters;
  RobotGeometry robot;
  std::string robot_from;  // for people
  std::string urdf;        // of the robot; empty: there is none
  std::optional<PlayedObject> played;
};

// The configuration's; without one the defaults. `warn` gets names that nothing reads. Throws
// std::runtime_error, one line, if it is refused.
MonitorParameters readBagParameters(const BagFiles& files,
                                    const std::function<void(const std::string&)>& warn);

// What cycles with these parameters need. Of types that cameras send too, the objects' own topics
// alone.
BagSelection neededMessages(const MonitorParameters& parameters);

// `configured`: of readBagParameters(). Without a configuration the objects are the bags'
// deformable meshes, each named as its messages say or else by its topic, and the reference frame
// is the root link of a robot that comes as URDF, else base_link, or the transforms' root if they
// do not know that. `contents` gets the frames that joints and the URDF say. `object` is played if
// it isWanted(). `warn` gets what a user should know, a line each. Throws std::exceptions, one
// line, on anything that keeps the cycles from making sense: no mesh, no robot, a bad value.
BagSetup setUpBags(const BagFiles& files, const MonitorParameters& configured,
                   const SceneObject& object, BagContents* contents,
                   const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
