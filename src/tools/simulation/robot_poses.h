// Where a robot's links are at given joint positions.
#pragma once

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <Eigen/Geometry>
#include <map>
#include <string>

namespace deformable_contact_monitor {

// Poses a robot's links by its joints.
class RobotPoses {
 public:
  // Poses will be in the frame of the link `frame`. `robot` must be read from guarded() text
  // (robot/urdf_document.h); all other names are as in the URDF. Throws std::invalid_argument if
  // `frame` is not a link of the robot.
  RobotPoses(urdf::ModelInterfaceSharedPtr robot, std::string frame);

  // Returns the pose of each link at joint positions by name [rad or m]. Joints without a position
  // are at zero; mimic joints follow the joint that they mimic.
  std::map<std::string, Eigen::Isometry3d> at(const std::map<std::string, double>& positions) const;

 private:
  // Adds the poses of a link and of everything below it.
  void place(const urdf::Link& link, const Eigen::Isometry3d& pose,
             const std::map<std::string, double>& positions,
             std::map<std::string, Eigen::Isometry3d>* poses) const;

  urdf::ModelInterfaceSharedPtr robot_;
  std::string frame_;
};

}  // namespace deformable_contact_monitor
