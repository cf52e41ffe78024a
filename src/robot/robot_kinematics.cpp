// Where a robot's links are for given positions of its joints, by Orocos KDL.
//
// kdl_parser is not used: it makes planar and floating joints fixed ones, leaves out mimic joints'
// rules, and needs urdfdom's model as this does.
#include "robot/robot_kinematics.h"

#include <algorithm>
#include <kdl/segment.hpp>
#include <set>
#include <stdexcept>
#include <tuple>

#include "robot/nearest_name.h"

namespace deformable_contact_monitor {
namespace {

KDL::Vector toKdl(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

KDL::Frame toFrame(const RigidTransform& pose) {
  const double *const r = pose.rotation, *const t = pose.translation;
  return {KDL::Rotation(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]),
          KDL::Vector(t[0], t[1], t[2])};
}

RigidTransform toRigidTransform(const KDL::Frame& frame) {
  RigidTransform pose;
  std::copy_n(frame.M.data, 9, pose.rotation);
  std::copy_n(frame.p.data, 3, pose.translation);
  return pose;
}

// Returns why one number cannot be the position of a joint.
std::string typeProblem(const RobotJoint& joint) {
  const std::string name = "joint '" + joint.name + "' ";
  switch (joint.type) {
    case RobotJoint::Type::kFixed:
      return name + "is fixed, so it has no position";
    case RobotJoint::Type::kPlanar:
    case RobotJoint::Type::kFloating:
      return name + "is " + (joint.type == RobotJoint::Type::kPlanar ? "planar" : "floating") +
             ", and no single number is its position: leave it out, and it stays where it is";
    default:
      return name + "is of an unknown type";
  }
}

// Throws std::invalid_argument if nothing tells how a joint moves its link.
void requireSound(const RobotJoint& joint, bool is_driven) {
  if (!joint.tree_problem.empty()) throw std::invalid_argument(joint.tree_problem);
  if (!is_driven && !joint.mimic_problem.empty()) {
    throw std::invalid_argument(joint.mimic_problem + "; name it too, or correct the URDF");
  }
}

// Returns all joints, each after the joint of its parent link.
std::vector<const RobotJoint*> parentsFirst(const std::vector<RobotJoint>& joints) {
  std::multimap<std::string, const RobotJoint*> below;
  std::set<std::string> children;
  for (const RobotJoint& joint : joints) {
    below.emplace(joint.parent, &joint);
    children.insert(joint.child);
  }
  std::vector<const RobotJoint*> ordered;
  std::set<std::string> done;  // a link of several parents could be in a loop
  const auto add_below = [&](const std::string& link) {
    if (!done.insert(link).second) return;
    const auto [first, last] = below.equal_range(link);
    for (auto found = first; found != last; ++found) ordered.push_back(found->second);
  };
  for (auto found = below.begin(); found != below.end(); found = below.upper_bound(found->first)) {
    if (children.count(found->first) == 0) add_below(found->first);
  }
  for (std::size_t i = 0; i < ordered.size(); ++i) add_below(ordered[i]->child);
  return ordered;
}

}  // namespace

bool RobotJoint::operator==(const RobotJoint& other) const {
  const auto all = [](const RobotJoint& j) {
    const urdf::Vector3& p = j.origin.position;
    const urdf::Rotation& r = j.origin.rotation;
    return std::make_tuple(j.name, j.parent, j.child, j.type, p.x, p.y, p.z, r.x, r.y, r.z, r.w,
                           j.axis.x, j.axis.y, j.axis.z, j.lower, j.upper, j.max_velocity, j.mimics,
                           j.multiplier, j.offset);
  };
  return all(*this) == all(other);
}

KDL::Segment toSegment(const RobotJoint& joint) {
  const urdf::Rotation& r = joint.origin.rotation;
  const KDL::Frame origin(KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w),
                          toKdl(joint.origin.position));
  if (!joint.hasPosition()) return KDL::Segment(KDL::Joint(KDL::Joint::None), origin);
  const auto type =
      joint.type == RobotJoint::Type::kPrismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
  return KDL::Segment(KDL::Joint(origin.p, origin.M * toKdl(joint.axis), type), origin);
}

// How a moved link is posed in the link that carries it.
struct JointMotion::Step {
  // The step of the link that carries it, or its place in present_.
  bool is_parent_moved;
  std::size_t parent;
  std::optional<Drive> drive;  // nothing: the joint stays
  // The joint's two links in present_, if they tell how it stays; a fixed joint needs none.
  std::optional<std::pair<std::size_t, std::size_t>> stays;
  KDL::Segment segment;
  // The pose in the parent of a joint that stays; of the parent itself, if that does not move.
  KDL::Frame still{}, base{};
  KDL::Frame pose{};  // of the latest state
};

JointMotion::JointMotion(JointMotion&&) noexcept = default;
JointMotion& JointMotion::operator=(JointMotion&&) noexcept = default;
JointMotion::~JointMotion() = default;

JointMotion::JointMotion(const std::vector<RobotJoint>& joints,
                         const std::vector<std::string>& names) {
  JointsByName by_name;
  for (const RobotJoint& joint : joints) {
    const auto [found, is_new] = by_name.emplace(joint.name, &joint);
    if (!is_new) found->second = nullptr;
  }
  nameJoints(by_name, names);
  std::map<std::string, std::size_t> steps;
  for (const RobotJoint* joint : parentsFirst(joints)) {
    const std::optional<Drive> drive = driveOf(*joint, by_name);
    if (!drive && steps.count(joint->parent) == 0) continue;
    requireSound(*joint, drive.has_value());
    addLink(*joint, drive, steps);
    steps.emplace(joint->child, steps_.size() - 1);
  }
}

void JointMotion::nameJoints(const JointsByName& joints, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto found = joints.find(name);
    if (found == joints.end()) {
      std::vector<std::string> known;
      for (const auto& [other, joint] : joints) {
        if (joint != nullptr && joint->hasPosition()) known.push_back(other);
      }
      throw std::invalid_argument("the robot has no joint '" + name + "'" +
                                  nearestNameHint(name, known));
    }
    if (found->second == nullptr) {
      throw std::invalid_argument("several robots have a joint '" + name +
                                  "'; give each robot its own frame_prefix");
    }
    const RobotJoint& joint = *found->second;
    if (!joint.hasPosition()) throw std::invalid_argument(typeProblem(joint));
    requireSound(joint, true);
    if (!index_of_.emplace(name, limits_.size()).second) {
      throw std::invalid_argument("joint '" + name + "' is named twice");
    }
    limits_.emplace_back(joint.lower, joint.upper);
  }
}

// Follows mimic joints that mimic one another, as far as there are joints.
std::optional<JointMotion::Drive> JointMotion::driveOf(const RobotJoint& joint,
                                                       const JointsByName& joints) const {
  Drive drive{0, 1, 0};
  const RobotJoint* followed = &joint;
  for (std::size_t i = 0; i <= joints.size(); ++i) {
    const auto named = index_of_.find(followed->name);
    if (named != index_of_.end()) {
      drive.index = named->second;
      return drive;
    }
    const auto found = joints.find(followed->mimics);
    const bool is_known = found != joints.end() && found->second != nullptr;
    if (!followed->hasPosition() || !is_known) return std::nullopt;
    drive.offset += drive.multiplier * followed->offset;
    drive.multiplier *= followed->multiplier;
    followed = found->second;
  }
  return std::nullopt;
}

void JointMotion::addLink(const RobotJoint& joint, const std::optional<Drive>& drive,
                          const std::map<std::string, std::size_t>& steps) {
  const auto parent = steps.find(joint.parent);
  const bool is_parent_moved = parent != steps.end();
  Step step{is_parent_moved, is_parent_moved ? parent->second : presentIndex(joint.parent), drive,
            std::nullopt, toSegment(joint)};
  if (!drive && joint.type != RobotJoint::Type::kFixed) {
    step.stays = {presentIndex(joint.parent), presentIndex(joint.child)};
  }
  step.still = step.segment.pose(0);
  constexpr double kAnyPosition = 0.5;
  if (!step.stays && !isFinite(toRigidTransform(step.segment.pose(kAnyPosition)))) {
    throw std::invalid_argument("joint '" + joint.name +
                                "' has an origin that is not finite, or an axis without direction");
  }
  steps_.push_back(std::move(step));
  moved_.push_back(joint.child);
}

std::size_t JointMotion::presentIndex(const std::string& link) {
  const auto found = std::find(present_.begin(), present_.end(), link);
  const auto index = static_cast<std::size_t>(found - present_.begin());
  if (found == present_.end()) present_.push_back(link);
  return index;
}

void JointMotion::setPresent(const std::vector<RigidTransform>& poses) {
  std::vector<KDL::Frame> frames;
  frames.reserve(poses.size());
  for (const RigidTransform& pose : poses) frames.push_back(toFrame(pose));
  for (Step& step : steps_) {
    if (!step.is_parent_moved) step.base = frames.at(step.parent);
    if (!step.stays) continue;
    step.still = frames.at(step.stays->first).Inverse() * frames.at(step.stays->second);
  }
}

void JointMotion::pose(const double* positions, RigidTransform* poses) {
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    Step& step = steps_[i];
    const KDL::Frame& base = step.is_parent_moved ? steps_[step.parent].pose : step.base;
    if (step.drive) {
      const Drive& drive = *step.drive;
      const double position = drive.multiplier * positions[drive.index] + drive.offset;
      step.pose = base * step.segment.pose(position);
    } else {
      step.pose = base * step.still;
    }
    poses[i] = toRigidTransform(step.pose);
  }
}

bool JointMotion::isBeyondLimits(const double* positions) const {
  for (std::size_t i = 0; i < limits_.size(); ++i) {
    if (positions[i] < limits_[i].first || positions[i] > limits_[i].second) return true;
  }
  return false;
}

}  // namespace deformable_contact_monitor
