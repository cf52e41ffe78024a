// A recorded robot's frames by its joints, where TF does not have them.
#include "tools/bags/joint_transforms.h"

#include <ros/console.h>
#include <urdf_model/joint.h>
#include <urdf_model/link.h>
#include <urdf_parser/urdf_parser.h>

#include <kdl_parser/kdl_parser.hpp>
#include <stdexcept>

#include "robot/urdf_text.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kDeepest = 1000;  // links one below the other; KDL's parser descends by recursion

int depthOf(const urdf::ModelInterface& model, urdf::LinkConstSharedPtr link) {
  int depth = 0;
  while (link->parent_joint && depth <= kDeepest) {
    link = model.getLink(link->parent_joint->parent_link_name);
    ++depth;
  }
  return depth;
}

geometry_msgs::TransformStamped message(const std::string& parent, const std::string& frame,
                                        const KDL::Frame& pose) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = parent;
  transform.child_frame_id = frame;
  transform.transform.translation.x = pose.p.x();
  transform.transform.translation.y = pose.p.y();
  transform.transform.translation.z = pose.p.z();
  geometry_msgs::Quaternion& q = transform.transform.rotation;
  pose.M.GetQuaternion(q.x, q.y, q.z, q.w);
  return transform;
}

}  // namespace

JointTransforms::JointTransforms(const std::string& urdf_xml,
                                 const std::function<bool(const std::string& frame)>& wanted) {
  const urdf::ModelInterfaceSharedPtr model =
      urdf::parseURDF(readUrdfText(urdf_xml, GeometryKind::kCollision).xml);
  if (!model) throw std::invalid_argument("urdfdom cannot read it");
  for (const auto& [name, link] : model->links_) {
    if (depthOf(*model, link) <= kDeepest) continue;
    throw std::invalid_argument("more than " + std::to_string(kDeepest) +
                                " links hang one below the other");
  }
  // It would say that floating joints become fixed ones; here they do not.
  ros::console::set_logger_level("ros.kdl_parser", ros::console::levels::Fatal);
  KDL::Tree tree;
  if (!kdl_parser::treeFromUrdfModel(*model, tree)) {
    throw std::invalid_argument("KDL cannot make a tree of it");
  }
  for (const auto& [name, joint] : model->joints_) {
    const std::string frame = unguarded(joint->child_link_name);
    const std::string parent = unguarded(joint->parent_link_name);
    if (!wanted(frame)) continue;
    const KDL::Segment& segment = tree.getSegment(joint->child_link_name)->second.segment;
    if (joint->type == urdf::Joint::FIXED) {
      fixed_.push_back(message(parent, frame, segment.pose(0)));
    } else if (joint->type == urdf::Joint::REVOLUTE || joint->type == urdf::Joint::CONTINUOUS ||
               joint->type == urdf::Joint::PRISMATIC) {
      Moving moving{parent, frame, unguarded(name), 1, 0, segment};
      if (joint->mimic) {
        moving.joint = unguarded(joint->mimic->joint_name);
        moving.multiplier = joint->mimic->multiplier;
        moving.offset = joint->mimic->offset;
      }
      moving_.push_back(std::move(moving));
    }
  }
}

std::vector<geometry_msgs::TransformStamped> JointTransforms::at(
    const sensor_msgs::JointState& state) const {
  const std::map<std::string, double> positions = positionsIn(state);
  std::vector<geometry_msgs::TransformStamped> transforms;
  for (const Moving& moving : moving_) {
    const auto found = positions.find(moving.joint);
    if (found == positions.end()) continue;
    transforms.push_back(
        message(moving.parent, moving.frame,
                moving.segment.pose(moving.multiplier * found->second + moving.offset)));
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
