// Where all links of one robot are for given positions of its joints, when nothing else is known of
// it: for planners, simulations and measurements.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "core/rigid_transform.h"
#include "robot/robot_geometry.h"
#include "robot/robot_kinematics.h"

namespace deformable_contact_monitor {

// Poses links in the frame of one of them. Planar and floating joints stay at their origins. One
// thread at a time.
class RobotPoses {
 public:
  // Poses will be in the frame of this link of the first robot; empty: of its root link. Throws
  // std::invalid_argument if it is no link, if a joint has a tree_problem or a mimic_problem, and
  // as JointMotion does.
  RobotPoses(const RobotGeometry& robot, std::string frame);

  // Returns the joints that have a position of their own, by name. Mimic joints follow them.
  const std::vector<RobotJoint>& joints() const { return joints_; }
  // Returns all links, those that joints move first.
  const std::vector<std::string>& links() const { return links_; }
  // Returns how many links joints() move. In the frame of a link that moves, others move too.
  std::size_t movedCount() const { return motion_.movedLinks().size(); }

  // Writes the poses of links(), in their order, for one position [rad or m] of each of joints().
  void pose(const double* positions, RigidTransform* poses);

  // Returns the pose of each link at joint positions by name [rad or m]. Joints without a position
  // are at zero; unknown names are ignored.
  std::map<std::string, Eigen::Isometry3d> at(const std::map<std::string, double>& positions);

 private:
  std::vector<RobotJoint> joints_;
  JointMotion motion_;
  std::vector<std::string> links_;
  std::vector<RigidTransform> still_;  // of the links that do not move, in the root's frame
  std::size_t frame_ = 0;              // in links_
  bool is_root_ = true;                // the frame is the root link
};

}  // namespace deformable_contact_monitor
