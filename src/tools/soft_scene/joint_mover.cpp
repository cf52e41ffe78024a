// Moves a robot's joints along sinusoids. Each joint has a rate and a phase of its own, drawn from
// a generator whose sequence the C++ standard fixes.
#include "tools/soft_scene/joint_mover.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_contact_monitor {
namespace {

// The limits of the motion. It is slow enough to watch, and large enough to move a cloth.
constexpr double kTurn = 6.283185307179586;
constexpr double kMaxAmplitude = 0.5;   // [rad] or [m]
constexpr double kShareOfRange = 0.7;   // of half the range between the limits
constexpr double kFastest = kTurn / 6;  // [rad/s]
constexpr double kSlowest = kTurn / 12;

}  // namespace

// The random numbers are scaled by hand, because the distributions of the standard library differ
// between implementations. The peak velocity of a sinusoid is amplitude times rate; it is kept to
// half of the joint's limit.
JointMover::JointMover(const std::vector<RobotJoint>& joints, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (const RobotJoint& joint : joints) {
    if (!joint.hasPosition() || !joint.mimics.empty()) continue;
    Swing swing{0, kMaxAmplitude, 0, 0};
    swing.rate = kSlowest + (kFastest - kSlowest) * (random() / 4294967296.0);
    swing.phase = kTurn * (random() / 4294967296.0);
    if (std::isfinite(joint.lower) && std::isfinite(joint.upper)) {
      swing.middle = (joint.lower + joint.upper) / 2;
      swing.amplitude =
          std::clamp(kShareOfRange * (joint.upper - joint.lower) / 2, 0.0, kMaxAmplitude);
    }
    if (joint.max_velocity > 0 && swing.amplitude > 0) {
      swing.rate = std::min(swing.rate, joint.max_velocity / (2 * swing.amplitude));
    }
    names_.push_back(joint.name);
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
