// The robot of a scene: its links' meshes, and where they are.
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/JointState.h>
#include <tf2_ros/transform_listener.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "robot/robot_geometry.h"
#include "robot/robot_poses.h"
#include "tools/simulation/scene_object.h"

namespace deformable_contact_monitor {

// A robot as its description says.
struct Robot {
  std::string urdf_xml;
  RobotGeometry geometry;
};

// Reads a URDF. Throws std::exception, one line, if it or one of its meshes cannot be read.
Robot readRobot(const std::string& urdf_xml);

// Joints that this program moves.
struct MovedJoints {
  std::vector<std::string> names;
  std::function<std::vector<double>(double time_s)> positions_at;
};

// Knows where the links are: by joints that this program moves, by joint_states, or by TF.
class SceneRobot {
 public:
  // `moved` may be null. `node` may be null if it is not, and with `by_tf` must not be. All must
  // outlive this. Throws as RobotPoses does, unless `by_tf`.
  SceneRobot(const Robot& robot, const std::string& frame, const MovedJoints* moved, bool by_tf,
             ros::NodeHandle* node);
  SceneRobot(const SceneRobot&) = delete;
  SceneRobot& operator=(const SceneRobot&) = delete;

  // Moves the links to where they are at `time_s` of the scene, or are by the last message.
  void moveTo(double time_s);

  // Returns the pose of a link in the frame of the scene; nothing if it is not known.
  std::optional<Eigen::Isometry3d> poseOf(const std::string& link) const;

  // Returns the positions of the joints that this program moves, at the time of moveTo(); null if
  // it moves none.
  const sensor_msgs::JointState* movedJoints() const { return moved_ ? &joints_ : nullptr; }

 private:
  // Stores positions from joint_states. A message may hold only some of the joints.
  void remember(const sensor_msgs::JointStateConstPtr& message);

  const MovedJoints* moved_;
  const std::string frame_;
  std::optional<RobotPoses> poses_;
  std::map<std::string, Eigen::Isometry3d> pose_of_link_;
  std::map<std::string, double> positions_;
  sensor_msgs::JointState joints_;
  ros::Subscriber subscriber_;
  tf2_ros::Buffer buffer_;
  std::unique_ptr<tf2_ros::TransformListener> listener_;
};

}  // namespace deformable_contact_monitor
