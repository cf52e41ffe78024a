// Builds a KDL segment for each joint of a URDF, and poses it by joint states.
#include "tools/bags/joint_transforms.h"

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

}  // namespace

JointTransforms::JointTransforms(const std::string& urdf_xml, const std::string& frame_prefix,
                                 const std::function<bool(const std::string& frame)>& wanted) {
  for (const RobotJoint& joint : readUrdf(urdf_xml, GeometryKind::kCollision).joints) {
    const std::string frame = frame_prefix + joint.child, parent = frame_prefix + joint.parent;
    const bool is_fixed = joint.type == RobotJoint::Type::kFixed;
    if ((!is_fixed && !joint.hasPosition()) || !wanted(frame)) continue;
    const KDL::Segment segment = toSegment(joint);
    if (is_fixed) {
      fixed_.push_back(stamped(parent, frame, toMessage(segment.pose(0))));
      continue;
    }
    const double multiplier = joint.multiplier, offset = joint.offset;
    moving_.push_back({parent, frame, joint.mimics.empty() ? joint.name : joint.mimics,
                       [segment, multiplier, offset](double position) {
                         return toMessage(segment.pose(multiplier * position + offset));
                       }});
  }
}

std::vector<geometry_msgs::TransformStamped> JointTransforms::at(
    const sensor_msgs::JointState& state) const {
  const std::map<std::string, double> positions = positionsIn(state);
  std::vector<geometry_msgs::TransformStamped> transforms;
  for (const Moving& moving : moving_) {
    const auto found = positions.find(moving.joint);
    // The message may have only some of the joints.
    if (found == positions.end()) continue;
    transforms.push_back(stamped(moving.parent, moving.frame, moving.pose(found->second)));
    transforms.back().header.stamp = state.header.stamp;
  }
  return transforms;
}

std::map<std::string, double> positionsIn(const sensor_msgs::JointState& state) {
  std::map<std::string, double> positions;
  if (state.name.size() != state.position.size()) return positions;
  for (std::size_t i = 0; i < state.name.size(); ++i) positions[state.name[i]] = state.position[i];
  return positions;
}

}  // namespace deformable_contact_monitor
