// A robot's links as capsules for the cloth to lie on.
#pragma once

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "robot/robot_geometry.h"
#include "tools/common/cloth.h"

namespace deformable_contact_monitor {

// Along the mesh's longest principal axis, a little inside its mean surface, so that what lies on
// the capsule touches the mesh. `mesh` must have an area above zero.
Capsule fitCapsule(const TriangleMesh& mesh);

// A capsule for each link with a usable mesh of some area, in the link's frame.
std::map<std::string, Capsule> linkCapsules(const RobotGeometry& robot);

class RobotObstacles {
 public:
  // Obstacles will be in the frame of link `frame`. Links without usable geometry are none. `robot`
  // was read from guarded() text (robot/urdf_text.h); all other names are as in the URDF. Throws
  // std::invalid_argument if `frame` is no link of the robot.
  RobotObstacles(urdf::ModelInterfaceSharedPtr robot, const RobotGeometry& geometry,
                 std::string frame);

  // For joint positions by name [rad, m]; joints that are not named stand at zero, and joints that
  // mimic follow.
  std::vector<Capsule> at(const std::map<std::string, double>& positions) const;

 private:
  void place(const urdf::Link& link, const Eigen::Isometry3d& pose,
             const std::map<std::string, double>& positions,
             std::map<std::string, Eigen::Isometry3d>* poses) const;

  urdf::ModelInterfaceSharedPtr robot_;
  std::map<std::string, Capsule> capsules_;  // by link, in its frame
  std::string frame_;
};

}  // namespace deformable_contact_monitor
