#include "robot/robot_poses.h"

#include <algorithm>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

Eigen::Isometry3d toIsometry(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  return Eigen::Translation3d(pose.position.x, pose.position.y, pose.position.z) *
         Eigen::Quaterniond(r.w, r.x, r.y, r.z);
}

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

RigidTransform toRigidTransform(const Eigen::Isometry3d& from) {
  RigidTransform to;
  Eigen::Map<RowMajor>(to.rotation) = from.linear();
  Eigen::Map<Eigen::Vector3d>(to.translation) = from.translation();
  return to;
}

Eigen::Isometry3d toIsometry(const RigidTransform& from) {
  Eigen::Isometry3d to(Eigen::Translation3d(Eigen::Map<const Eigen::Vector3d>(from.translation)));
  to.linear() = Eigen::Map<const RowMajor>(from.rotation);
  return to;
}

// Returns where a link is with all joints at their origins, in the root's frame.
Eigen::Isometry3d placeAtOrigins(const std::vector<RobotJoint>& joints, const std::string& link) {
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  const std::string* child = &link;
  for (std::size_t i = 0; i <= joints.size(); ++i) {
    const auto of_child = [child](const RobotJoint& joint) { return joint.child == *child; };
    const auto found = std::find_if(joints.begin(), joints.end(), of_child);
    if (found == joints.end()) break;
    place = toIsometry(found->origin) * place;
    child = &found->parent;
  }
  return place;
}

// Throws std::invalid_argument if nothing tells how joints move or follow others.
std::vector<RobotJoint> movableJoints(const std::vector<RobotJoint>& joints) {
  for (const RobotJoint& joint : joints) {
    for (const std::string& problem : {joint.tree_problem, joint.mimic_problem}) {
      if (!problem.empty()) throw std::invalid_argument("robot description: " + problem);
    }
  }
  std::vector<RobotJoint> movable;
  std::copy_if(joints.begin(), joints.end(), std::back_inserter(movable),
               [](const RobotJoint& j) { return j.hasPosition() && j.mimics.empty(); });
  return movable;
}

std::vector<std::string> namesOf(const std::vector<RobotJoint>& joints) {
  std::vector<std::string> names;
  names.reserve(joints.size());
  for (const RobotJoint& joint : joints) names.push_back(joint.name);
  return names;
}

}  // namespace

RobotPoses::RobotPoses(const RobotGeometry& robot, std::string frame)
    : joints_(movableJoints(robot.joints)), motion_(robot.joints, namesOf(joints_)) {
  const auto place = [&robot](const std::string& link) {
    return toRigidTransform(placeAtOrigins(robot.joints, link));
  };
  if (frame.empty()) frame = robot.root_link;
  is_root_ = frame == robot.root_link;
  links_ = motion_.movedLinks();
  for (const std::string& link : robot.link_names) {
    if (std::count(links_.begin(), links_.begin() + movedCount(), link) != 0) continue;
    links_.push_back(link);
    still_.push_back(place(link));
  }
  const auto found = std::find(links_.begin(), links_.end(), frame);
  if (found == links_.end()) {
    throw std::invalid_argument("frame '" + frame + "' is no link of robot '" +
                                (robot.robots.empty() ? std::string() : robot.robots.front().name) +
                                "'");
  }
  frame_ = static_cast<std::size_t>(found - links_.begin());
  std::vector<RigidTransform> present;
  for (const std::string& link : motion_.presentLinks()) present.push_back(place(link));
  motion_.setPresent(present);
}

void RobotPoses::pose(const double* positions, RigidTransform* poses) {
  motion_.pose(positions, poses);
  std::copy(still_.begin(), still_.end(), poses + movedCount());
  if (is_root_) return;
  const Eigen::Isometry3d to_frame = toIsometry(poses[frame_]).inverse();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    poses[i] = toRigidTransform(to_frame * toIsometry(poses[i]));
  }
}

std::map<std::string, Eigen::Isometry3d> RobotPoses::at(
    const std::map<std::string, double>& positions) {
  std::vector<double> in_order;
  for (const RobotJoint& joint : joints_) {
    const auto found = positions.find(joint.name);
    in_order.push_back(found == positions.end() ? 0 : found->second);
  }
  std::vector<RigidTransform> poses(links_.size());
  pose(in_order.data(), poses.data());
  std::map<std::string, Eigen::Isometry3d> by_name;
  for (std::size_t i = 0; i < links_.size(); ++i) by_name.emplace(links_[i], toIsometry(poses[i]));
  return by_name;
}

}  // namespace deformable_contact_monitor
