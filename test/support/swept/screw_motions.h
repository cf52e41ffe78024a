// Motions that are known at every time: a turn about an axis through the body's origin, which moves
// on a straight line.
#pragma once

#include <array>
#include <random>

#include "core/rigid_transform.h"
#include "core/substeps.h"

namespace deformable_contact_monitor {

using Place = std::array<double, 3>;  // [m]

Place placeOf(const RigidTransform& pose, const Place& in_body);

struct ScrewMotion {
  RigidTransform start;
  Place axis;    // unit, in the scene frame
  double angle;  // of the whole step [rad]
  Place way;     // of the origin [m]

  RigidTransform at(double part) const;

  // So many samples more than the two ends, at equal distances.
  BodyPath path(int between = 0) const;
};

// Uniform in [low, high].
double uniform(std::mt19937* random, double low, double high);
Place randomUnit(std::mt19937* random);

// Anywhere within `range` [m], turned by up to `most` [rad].
ScrewMotion randomScrewMotion(std::mt19937* random, double range, double most);

}  // namespace deformable_contact_monitor
