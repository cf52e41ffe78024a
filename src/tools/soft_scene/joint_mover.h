// Moves a robot's joints along sinusoids, within their limits.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "robot/robot_joint.h"

namespace deformable_contact_monitor {

// Moves every joint that has a position and mimics no other, in alphabetical order. The same seed
// gives the same motion.
class JointMover {
 public:
  // `joints` are those of a robot, by name.
  JointMover(const std::vector<RobotJoint>& joints, std::uint32_t seed);

  const std::vector<std::string>& names() const { return names_; }

  // Returns one position per name at `time_s` [rad or m]. Positions swing about the middle of the
  // limits (without limits: about zero), stay within them, and below half of the velocity limit.
  std::vector<double> positions(double time_s) const;

 private:
  struct Swing {
    double middle, amplitude, rate;  // rate [rad/s]
    double phase;                    // [rad]
  };

  std::vector<std::string> names_;
  std::vector<Swing> swings_;
};

}  // namespace deformable_contact_monitor
