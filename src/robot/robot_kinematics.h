// Where a robot's links are for given positions of its joints, by Orocos KDL.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/rigid_transform.h"
#include "robot/robot_joint.h"

namespace KDL {
class Segment;
}

namespace deformable_contact_monitor {

// Returns the segment from a joint's parent link to its child link. It is fixed if no single number
// is the joint's position.
KDL::Segment toSegment(const RobotJoint& joint);

// Poses the links that some joints of a robot, or of several robots, move. These joints are named
// once, and have other positions in each state. A mimic joint that is not named follows the joint
// that it mimics. Every other joint stays as it is at present, which setPresent() tells by the
// poses of its two links: so joints of any type may stay. One thread at a time.
class JointMotion {
 public:
  // Throws std::invalid_argument, naming the joint and a similar one, for a name that no joint has,
  // that is there twice, that joints of two robots have, or whose joint is fixed, planar or
  // floating, as no single number is its position; and for a joint that moves a link while its axis
  // or origin cannot be used, it has a tree_problem, or a mimic_problem and is not named.
  JointMotion(const std::vector<RobotJoint>& joints, const std::vector<std::string>& names);
  JointMotion(JointMotion&&) noexcept;
  JointMotion& operator=(JointMotion&&) noexcept;
  ~JointMotion();

  // Returns the links that the joints move, each after the link that carries it.
  const std::vector<std::string>& movedLinks() const { return moved_; }
  // Returns the links whose present poses must be known. Of a chain that moves as a whole this is
  // the link that carries it, which does not move.
  const std::vector<std::string>& presentLinks() const { return present_; }

  // Sets the present poses of presentLinks(), in their order, in any frame.
  void setPresent(const std::vector<RigidTransform>& poses);

  // Writes the poses of movedLinks() in the frame of setPresent(), in their order, for one position
  // [rad or m] of each named joint.
  void pose(const double* positions, RigidTransform* poses);

  // Returns whether a position of a named joint is beyond its limits.
  bool isBeyondLimits(const double* positions) const;

 private:
  struct Step;

  // How a joint follows from the positions: multiplier * positions[index] + offset.
  struct Drive {
    std::size_t index;
    double multiplier, offset;
  };
  // Null: joints of several robots have that name.
  using JointsByName = std::map<std::string, const RobotJoint*>;

  void nameJoints(const JointsByName& joints, const std::vector<std::string>& names);
  std::optional<Drive> driveOf(const RobotJoint& joint, const JointsByName& joints) const;
  void addLink(const RobotJoint& joint, const std::optional<Drive>& drive,
               const std::map<std::string, std::size_t>& steps);
  std::size_t presentIndex(const std::string& link);

  std::map<std::string, std::size_t> index_of_;    // of the named joints
  std::vector<std::pair<double, double>> limits_;  // of the named joints
  std::vector<std::string> moved_, present_;
  std::vector<Step> steps_;  // of movedLinks()
};

}  // namespace deformable_contact_monitor
