// Points nearly in a plane, for which float32 errs about as far as it can.
#pragma once

#include <vector>

#include "hard_pairs.h"

namespace deformable_contact_monitor {

// Four points whose float32 determinant, PlaneFilter's, has the wrong sign.
struct HardOrientation {
  Vec3f p[4];
  double off_by = 0;  // the determinant, in units of 2^-24 of the sum of its terms' sizes
};

enum class FirstPoint { kAnywhere, kAtOrigin };  // there differences from it are exact

// By climbing from random points, so many times. The same on every machine.
std::vector<HardOrientation> hardOrientations(unsigned seed, int climbs, FirstPoint first);

// Pairs whose verdict may hang on one of these: an edge is its first two points, one of the other
// triangle the others, third vertices lie anywhere. So many for each.
std::vector<TrianglesPair> pairsOn(const std::vector<HardOrientation>& hard, int each);

double worstOf(const std::vector<HardOrientation>& hard);

}  // namespace deformable_contact_monitor
