// Where a robot's links are at given joint positions.
#include "tools/simulation/robot_poses.h"

#include <urdf_model/joint.h>
#include <urdf_model/link.h>

#include <stdexcept>
#include <utility>

#include "robot/urdf_document.h"

namespace deformable_contact_monitor {
namespace {

// Converts a URDF pose.
Eigen::Isometry3d toIsometry(const urdf::Pose& pose) {
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  isometry.translate(Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z));
  double x = 0, y = 0, z = 0, w = 1;
  pose.rotation.getQuaternion(x, y, z, w);
  isometry.rotate(Eigen::Quaterniond(w, x, y, z));
  return isometry;
}

// Returns the position of a joint, which may mimic another one; 0 if it is not known.
double positionOf(const urdf::Joint& joint, const std::map<std::string, double>& positions) {
  const std::string& name = joint.mimic == nullptr ? joint.name : joint.mimic->joint_name;
  const auto found = positions.find(unguarded(name));
  const double position = found == positions.end() ? 0 : found->second;
  return joint.mimic == nullptr ? position
                                : joint.mimic->multiplier * position + joint.mimic->offset;
}

// Returns the pose of a joint's child link in the parent link.
Eigen::Isometry3d childPose(const urdf::Joint& joint,
                            const std::map<std::string, double>& positions) {
  Eigen::Isometry3d pose = toIsometry(joint.parent_to_joint_origin_transform);
  const Eigen::Vector3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
  if (joint.type == urdf::Joint::PRISMATIC) {
    pose.translate(positionOf(joint, positions) * axis);
  } else if (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS) {
    pose.rotate(Eigen::AngleAxisd(positionOf(joint, positions), axis.normalized()));
  }
  return pose;
}

}  // namespace

RobotPoses::RobotPoses(urdf::ModelInterfaceSharedPtr robot, std::string frame)
    : robot_(std::move(robot)), frame_(std::move(frame)) {
  if (robot_->getLink(guarded(frame_)) == nullptr) {
    throw std::invalid_argument("frame '" + frame_ + "' is no link of robot '" +
                                unguarded(robot_->getName()) + "'");
  }
}

// Walks down the tree of links. All poses are in the root's frame.
void RobotPoses::place(const urdf::Link& link, const Eigen::Isometry3d& pose,
                       const std::map<std::string, double>& positions,
                       std::map<std::string, Eigen::Isometry3d>* poses) const {
  (*poses)[unguarded(link.name)] = pose;
  for (const auto& joint : link.child_joints) {
    place(*robot_->getLink(joint->child_link_name), pose * childPose(*joint, positions), positions,
          poses);
  }
}

// Computes all poses in the root's frame first.
std::map<std::string, Eigen::Isometry3d> RobotPoses::at(
    const std::map<std::string, double>& positions) const {
  std::map<std::string, Eigen::Isometry3d> poses;
  place(*robot_->getRoot(), Eigen::Isometry3d::Identity(), positions, &poses);
  const Eigen::Isometry3d to_frame = poses.at(frame_).inverse();
  for (auto& [link, pose] : poses) pose = to_frame * pose;
  return poses;
}

}  // namespace deformable_contact_monitor
