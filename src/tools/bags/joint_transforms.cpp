// Builds a KDL segment for each joint of a URDF, and poses it by joint states.
#include "tools/bags/joint_transforms.h"

#include <algorithm>
#include <kdl/segment.hpp>

#include "robot/robot_kinematics.h"
#include "robot/urdf_document.h"

namespace deformable_contact_monitor {
namespace {

// Converts a KDL frame.
geometry_msgs::Transform toMessage(const KDL::Frame& pose) {
  geometry_msgs::Transform transform;
  transform.translation.x = pose.p.x();
  transform.translation.y = pose.p.y();
  transform.translation.z = pose.p.z();
  geometry_msgs::Quaternion& q = transform.rotation;
  pose.M.GetQuaternion(q.x, q.y, q.z, q.w);
  return transform;
}

// Makes a transform of `frame` in `parent` without a stamp.
geometry_msgs::TransformStamped stamped(const std::string& parent, const std::string& frame,
                                        const geometry_msgs::Transform& transform) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.child_frame_id = frame;
  message.transform = transform;
  return message;
}

// Returns the joint, and those that it follows if it has no position itself. Joints that mimic one
// another in a circle are followed once around.
std::vector<JointTransforms::Moving::Source> sourcesOf(const RobotJoint& joint,
                                                       const std::vector<RobotJoint>& all) {
  std::vector<JointTransforms::Moving::Source> sources = {{joint.name, 1, 0}};
  const RobotJoint* follower = &joint;
  while (!follower->mimics.empty() && sources.size() <= all.size()) {
    const JointTransforms::Moving::Source last = sources.back();
    sources.push_back({follower->mimics, last.multiplier * follower->multiplier,
                       last.multiplier * follower->offset + last.offset});
    const auto next = std::find_if(all.begin(), all.end(), [&](const RobotJoint& j) {
      return j.name == sources.back().joint;
    });
    if (next == all.end()) break;
    follower = &*next;
  }
  return sources;
}

}  // namespace

JointTransforms::JointTransforms(const std::string& urdf_xml, const std::string& frame_prefix,
                                 const std::function<bool(const std::string& frame)>& wanted) {
  const std::vector<RobotJoint> joints = readUrdf(urdf_xml, GeometryKind::kCollision).joints;
  for (const RobotJoint& joint : joints) {
    const std::string frame = frame_prefix + joint.child, parent = frame_prefix + joint.parent;
    const bool is_fixed = joint.type == RobotJoint::Type::kFixed;
    if ((!is_fixed && !joint.hasPosition()) || !wanted(frame)) continue;
    const KDL::Segment segment = toSegment(joint);
    if (is_fixed) {
      fixed_.push_back(stamped(parent, frame, toMessage(segment.pose(0))));
      continue;
    }
    moving_.push_back({parent, frame, sourcesOf(joint, joints),
                       [segment](double position) { return toMessage(segment.pose(position)); }});
  }
}

std::vector<geometry_msgs::TransformStamped> JointTransforms::at(
    const sensor_msgs::JointState& state) const {
  const std::map<std::string, double> positions = positionsIn(state);
  std::vector<geometry_msgs::TransformStamped> transforms;
  for (const Moving& moving : moving_) {
    // The message may have only some of the joints.
    const auto source =
        std::find_if(moving.sources.begin(), moving.sources.end(),
                     [&](const Moving::Source& of) { return positions.count(of.joint) > 0; });
    if (source == moving.sources.end()) continue;
    const double position = source->multiplier * positions.at(source->joint) + source->offset;
    transforms.push_back(stamped(moving.parent, moving.frame, moving.pose(position)));
    transforms.back().header.stamp = state.header.stamp;
  }
  return transforms;
}

std::map<std::string, double> positionsIn(const sensor_msgs::JointState& state) {
  std::map<std::string, double> positions;
  if (state.name.size() != state.position.size()) return positions;
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    positions.emplace(state.name[i], state.position[i]);
  }
  return positions;
}

}  // namespace deformable_contact_monitor
