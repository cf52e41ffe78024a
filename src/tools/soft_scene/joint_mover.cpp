// Moves a robot's joints along sinusoids. Each joint has a rate and a phase of its own, drawn from
// a generator whose sequence the C++ standard fixes.
#include "tools/soft_scene/joint_mover.h"

#include <urdf_model/joint.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "robot/urdf_document.h"

namespace deformable_contact_monitor {
namespace {

// The limits of the motion. It is slow enough to watch, and large enough to move a cloth.
constexpr double kTurn = 6.283185307179586;
constexpr double kMaxAmplitude = 0.5;   // [rad] or [m]
constexpr double kShareOfRange = 0.7;   // of half the range between the limits
constexpr double kFastest = kTurn / 6;  // [rad/s]
constexpr double kSlowest = kTurn / 12;

// Returns whether the joint has one axis and follows no other joint.
bool moves(const urdf::Joint& joint) {
  const bool one_axis = joint.type == urdf::Joint::REVOLUTE ||
                        joint.type == urdf::Joint::CONTINUOUS ||
                        joint.type == urdf::Joint::PRISMATIC;
  return one_axis && joint.mimic == nullptr;
}

}  // namespace

// The random numbers are scaled by hand, because the distributions of the standard library differ
// between implementations. The peak velocity of a sinusoid is amplitude times rate; it is kept to
// half of the joint's limit.
JointMover::JointMover(const urdf::ModelInterface& robot, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (const auto& [name, joint] : robot.joints_) {
    if (!moves(*joint)) continue;
    Swing swing{0, kMaxAmplitude, 0, 0};
    swing.rate = kSlowest + (kFastest - kSlowest) * (random() / 4294967296.0);
    swing.phase = kTurn * (random() / 4294967296.0);
    if (joint->limits != nullptr) {
      const urdf::JointLimits& limits = *joint->limits;
      if (joint->type != urdf::Joint::CONTINUOUS) {
        swing.middle = (limits.lower + limits.upper) / 2;
        swing.amplitude =
            std::clamp(kShareOfRange * (limits.upper - limits.lower) / 2, 0.0, kMaxAmplitude);
      }
      if (limits.velocity > 0 && swing.amplitude > 0) {
        swing.rate = std::min(swing.rate, limits.velocity / (2 * swing.amplitude));
      }
    }
    names_.push_back(unguarded(name));
    swings_.push_back(swing);
  }
}

std::vector<double> JointMover::positions(double time_s) const {
  std::vector<double> positions;
  positions.reserve(swings_.size());
  for (const Swing& swing : swings_) {
    positions.push_back(swing.middle +
                        swing.amplitude * std::sin(swing.rate * time_s + swing.phase));
  }
  return positions;
}

}  // namespace deformable_contact_monitor
