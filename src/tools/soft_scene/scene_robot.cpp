// The robot of a scene: its links' meshes, and where they are.
#include "tools/soft_scene/scene_robot.h"

#include <ros/ros.h>
#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>

namespace deformable_contact_monitor {

Robot readRobot(const std::string& urdf_xml) {
  Robot robot;
  MeshReading reading;
  reading.stop = ros::isShuttingDown;
  robot.urdf_xml = urdf_xml;
  robot.geometry = loadRobotGeometry(urdf_xml, {}, makeRosResolver(), reading);
  return robot;
}

SceneRobot::SceneRobot(const Robot& robot, const std::string& frame, const MovedJoints* moved,
                       bool by_tf, ros::NodeHandle* node)
    : moved_(moved), frame_(frame) {
  if (by_tf) {
    listener_ = std::make_unique<tf2_ros::TransformListener>(buffer_);
    return;
  }
  poses_.emplace(robot.geometry, frame);
  if (moved_ != nullptr) {
    joints_.name = moved_->names;
  } else {
    subscriber_ = node->subscribe("joint_states", 10, &SceneRobot::remember, this);
  }
}

void SceneRobot::moveTo(double time_s) {
  if (!poses_) return;
  if (moved_ != nullptr) {
    joints_.position = moved_->positions_at(time_s);
    for (std::size_t i = 0; i < joints_.name.size(); ++i) {
      positions_[joints_.name[i]] = joints_.position[i];
    }
  }
  // Before the first message, links are nowhere: they would jump from where the joints are at zero.
  if (!positions_.empty()) pose_of_link_ = poses_->at(positions_);
}

std::optional<Eigen::Isometry3d> SceneRobot::poseOf(const std::string& link) const {
  if (poses_) {
    const auto found = pose_of_link_.find(link);
    return found == pose_of_link_.end() ? std::nullopt : std::optional(found->second);
  }
  try {
    return tf2::transformToEigen(buffer_.lookupTransform(frame_, link, ros::Time()));
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

void SceneRobot::remember(const sensor_msgs::JointStateConstPtr& message) {
  const std::size_t count = std::min(message->name.size(), message->position.size());
  for (std::size_t i = 0; i < count; ++i) positions_[message->name[i]] = message->position[i];
}

}  // namespace deformable_contact_monitor
