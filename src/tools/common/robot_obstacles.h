// Turns a robot's links into capsules that push the simulated cloth.
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

// Fits a capsule along the mesh's longest principal axis. It is a little smaller than the mean
// surface, so that a cloth that lies on the capsule touches the mesh. `mesh` must have an area
// above zero.
Capsule fitCapsule(const TriangleMesh& mesh);

// Returns a capsule for each link whose mesh is usable and has an area, in the link's frame.
std::map<std::string, Capsule> linkCapsules(const RobotGeometry& robot);

// Moves the links' capsules with the joints.
class RobotObstacles {
 public:
  // Obstacles will be in the frame of the link `frame`. Links without usable geometry are no
  // obstacles. `robot` must be read from guarded() text (robot/urdf_document.h); all other names
  // are as in the URDF. Throws std::invalid_argument if `frame` is not a link of the robot.
  RobotObstacles(urdf::ModelInterfaceSharedPtr robot, const RobotGeometry& geometry,
                 std::string frame);

  // Returns the obstacles at joint positions by name [rad or m]. Joints without a position are at
  // zero; mimic joints follow the joint that they mimic.
  std::vector<Capsule> at(const std::map<std::string, double>& positions) const;

 private:
  // Adds the poses of a link and of everything below it.
  void place(const urdf::Link& link, const Eigen::Isometry3d& pose,
             const std::map<std::string, double>& positions,
             std::map<std::string, Eigen::Isometry3d>* poses) const;

  urdf::ModelInterfaceSharedPtr robot_;
  std::map<std::string, Capsule> capsules_;  // by link, in its frame
  std::string frame_;
};

}  // namespace deformable_contact_monitor
