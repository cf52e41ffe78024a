// Moves a robot's joints along sinusoids.
#pragma once

#include <urdf_model/model.h>

#include <cstdint>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Every joint that moves and mimics none, in alphabetical order. Deterministic by seed.
class JointMover {
 public:
  // Of a model that was read from guarded() text (robot/urdf_text.h); names() are as in the URDF.
  JointMover(const urdf::ModelInterface& robot, std::uint32_t seed);

  const std::vector<std::string>& names() const { return names_; }

  // Joint positions at `time_s` [rad, m], one per name: within the limits and below half of the
  // velocity limits, about the middle of the limits (joints without limits: about zero).
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
