// Builds a KDL segment for each joint of a URDF, and poses it by joint states.
#include "tools/bags/joint_transforms.h"

#include <urdf_model/joint.h>
#include <urdf_parser/urdf_parser.h>

#include <kdl/segment.hpp>
#include <stdexcept>

#include "robot/urdf_document.h"

namespace deformable_contact_monitor {
namespace {

KDL::Vector toKdl(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

// Returns true if one position, or none, gives the joint's pose.
bool isPosed(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::FIXED || joint.type == urdf::Joint::REVOLUTE ||
         joint.type == urdf::Joint::CONTINUOUS || joint.type == urdf::Joint::PRISMATIC;
}

// Returns the segment from a joint's parent link to its child link. isPosed(joint) must hold.
KDL::Segment toKdl(const urdf::Joint& joint) {
  const urdf::Pose& pose = joint.parent_to_joint_origin_transform;
  const KDL::Frame origin(
      KDL::Rotation::Quaternion(pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w),
      toKdl(pose.position));
  if (joint.type == urdf::Joint::FIXED) return KDL::Segment(KDL::Joint(KDL::Joint::None), origin);
  const auto type =
      joint.type == urdf::Joint::PRISMATIC ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
  return KDL::Segment(KDL::Joint(origin.p, origin.M * toKdl(joint.axis), type), origin);
}

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

// URDF names may contain characters that urdfdom changes; readUrdfText() guards them, and
// unguarded() restores them.
JointTransforms::JointTransforms(const std::string& urdf_xml, const std::string& frame_prefix,
                                 const std::function<bool(const std::string& frame)>& wanted) {
  const urdf::ModelInterfaceSharedPtr model =
      urdf::parseURDF(readUrdfText(urdf_xml, GeometryKind::kCollision).xml);
  if (!model) throw std::invalid_argument("urdfdom cannot read it");
  for (const auto& [name, joint] : model->joints_) {
    const std::string frame = frame_prefix + unguarded(joint->child_link_name);
    const std::string parent = frame_prefix + unguarded(joint->parent_link_name);
    if (!isPosed(*joint) || !wanted(frame)) continue;
    const KDL::Segment segment = toKdl(*joint);
    if (joint->type == urdf::Joint::FIXED) {
      fixed_.push_back(stamped(parent, frame, toMessage(segment.pose(0))));
      continue;
    }
    // A mimic joint's position is multiplier * position + offset of the other joint.
    const urdf::JointMimicSharedPtr mimic = joint->mimic;
    const double multiplier = mimic ? mimic->multiplier : 1, offset = mimic ? mimic->offset : 0;
    moving_.push_back({parent, frame, unguarded(mimic ? mimic->joint_name : name),
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
