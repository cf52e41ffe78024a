// Seeded random pairs of triangles in two states on small integers, where ties are the rule.
#pragma once

#include <random>
#include <vector>

#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

struct SweptPair {
  Triangle a0, a1, b0, b1;
};

// Coordinates are integers in [0, 8]. Still triangles, segments and points (in one state or in
// both), pairs in a common plane, and vertices that coincide in one state or in both are common.
// The same generator gives the same pairs on every machine.
SweptPair randomSweptPair(std::mt19937& generator);

// The points at `time` = numerator / denominator, times denominator: exact where the integers are
// below 2^24.
Triangle at(const Triangle& state0, const Triangle& state1, int numerator, int denominator);

// The distinct shared trajectories of a and b at that time, so scaled.
std::vector<Vec3f> sharedAt(const SweptPair& pair, int numerator, int denominator);

}  // namespace deformable_contact_monitor
