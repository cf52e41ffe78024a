// A recorded robot's frames by its joints, where TF does not have them.
#pragma once

#include <geometry_msgs/Transform.h>
#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/JointState.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// What robot_state_publisher would have sent, by KDL. Joints that mimic follow theirs; floating and
// planar ones stay unknown.
class JointTransforms {
 public:
  // `wanted`: says of each frame whether it is to be posed; those that TF has are not. Throws
  // std::invalid_argument, one line, if the URDF cannot be read.
  JointTransforms(const std::string& urdf_xml,
                  const std::function<bool(const std::string& frame)>& wanted);

  struct Moving {
    std::string parent, frame;
    std::string joint;                                              // that says where it is
    std::function<geometry_msgs::Transform(double position)> pose;  // of the frame in its parent
  };
  const std::vector<Moving>& moving() const { return moving_; }

  // Of the fixed joints, without a stamp.
  const std::vector<geometry_msgs::TransformStamped>& fixed() const { return fixed_; }

  // Of the joints that the message has a position of, at its stamp.
  std::vector<geometry_msgs::TransformStamped> at(const sensor_msgs::JointState& state) const;

 private:
  std::vector<Moving> moving_;
  std::vector<geometry_msgs::TransformStamped> fixed_;
};

// The position of each joint [rad, m]; none if there are not as many as names.
std::map<std::string, double> positionsIn(const sensor_msgs::JointState& state);

}  // namespace deformable_contact_monitor
