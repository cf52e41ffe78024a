// Moves a robot's joints along sinusoids, within their limits.
#pragma once

#include <urdf_model/model.h>

#include <cstdint>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Moves every joint that is not fixed and mimics no other, in alphabetical order. The same seed
// gives the same motion.
class JointMover {
 public:
  // `robot` was parsed from guarded() text (robot/urdf_document.h); names() are those of the URDF.
  JointMover(const urdf::ModelInterface& robot, std::uint32_t seed);

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
