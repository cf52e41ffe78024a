// Computes a robot's frames from recorded joint states, where TF does not have them.
//
// Bags of robots often have joint states and no TF. KDL computes the same poses as
// robot_state_publisher.
#pragma once

#include <geometry_msgs/Transform.h>
#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/JointState.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Computes the transforms that robot_state_publisher would have sent, with KDL. A mimic joint
// without a position of its own follows the joint that it mimics. Frames of floating and planar
// joints stay unknown.
class JointTransforms {
 public:
  // A link's frame is `frame_prefix` and its name. `wanted` returns true for frames that shall be
  // computed: those that TF does not have. Throws std::invalid_argument, one line, if the URDF
  // cannot be read.
  JointTransforms(const std::string& urdf_xml, const std::string& frame_prefix,
                  const std::function<bool(const std::string& frame)>& wanted);

  struct Moving {
    std::string parent, frame;
    // A joint whose position p gives the pose: the frame's joint is at multiplier * p + offset.
    struct Source {
      std::string joint;
      double multiplier, offset;
    };
    // The frame's own joint, the joint that it mimics, the one that this mimics, and so on. The
    // first of them that has a position counts.
    std::vector<Source> sources;
    // Returns the frame's pose in its parent at a position of its own joint [rad or m].
    std::function<geometry_msgs::Transform(double position)> pose;
  };
  const std::vector<Moving>& moving() const { return moving_; }

  // Returns the transforms of fixed joints, without a stamp.
  const std::vector<geometry_msgs::TransformStamped>& fixed() const { return fixed_; }

  // Returns the transforms of all joints that the message has a position of, with its stamp.
  std::vector<geometry_msgs::TransformStamped> at(const sensor_msgs::JointState& state) const;

 private:
  std::vector<Moving> moving_;
  std::vector<geometry_msgs::TransformStamped> fixed_;
};

// Returns the position of each joint [rad or m], the first one of a name that is there twice;
// nothing if there are not as many positions as names.
std::map<std::string, double> positionsIn(const sensor_msgs::JointState& state);

}  // namespace deformable_contact_monitor
