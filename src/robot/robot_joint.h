// A joint of a robot as its URDF describes it.
#pragma once

#include <urdf_model/joint.h>

#include <limits>
#include <string>

namespace deformable_contact_monitor {

// How a joint poses its child link in its parent link. Names of links have the robot's prefix, and
// so has the joint's own name, because two robots of one URDF have the same joints.
struct RobotJoint {
  enum class Type { kFixed, kRevolute, kContinuous, kPrismatic, kPlanar, kFloating, kUnknown };

  std::string name, parent, child;
  Type type = Type::kFixed;
  urdf::Pose origin;   // of the child at position 0
  urdf::Vector3 axis;  // in the child's frame; of any length but 0
  // The positions that the URDF permits [rad or m]; infinite without limits.
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double max_velocity = 0;  // [rad/s or m/s]; 0: not limited
  // A mimic joint is at multiplier * position + offset of that joint; empty: it is none.
  std::string mimics{};
  double multiplier = 1, offset = 0;
  // Why nothing tells where the joint's links are: a link has several parents, or there is a loop.
  std::string tree_problem{};
  std::string mimic_problem{};  // why nothing tells which joint a mimic joint follows

  // Returns whether one number is the joint's position.
  bool hasPosition() const {
    return type == Type::kRevolute || type == Type::kContinuous || type == Type::kPrismatic;
  }

  bool operator==(const RobotJoint& other) const;
};

}  // namespace deformable_contact_monitor
