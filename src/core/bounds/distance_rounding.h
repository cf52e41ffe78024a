// Distances in double as bounds in float32.
#pragma once

#include <cfloat>
#include <cmath>
#include <limits>

#include "core/vector3.h"

namespace deformable_contact_monitor {

// The greatest float32 that is not greater, for any distance >= 0; +inf stays.
inline float roundedDown(double distance_m) {
  if (distance_m > FLT_MAX) return std::isinf(distance_m) ? INFINITY : FLT_MAX;
  const auto rounded = static_cast<float>(distance_m);
  return rounded > distance_m ? std::nextafter(rounded, 0.0F) : rounded;
}

// The least float32 that is not less.
inline float roundedUp(double distance_m) {
  if (distance_m > FLT_MAX) return INFINITY;
  const auto rounded = static_cast<float>(distance_m);
  return rounded < distance_m ? std::nextafter(rounded, INFINITY) : rounded;
}

// The least distance [m] that is greater than the margin as float32; what is farther apart than it
// is not near by nearVerdict() (predicates/narrow_phase.h) either, which rounds to the nearest.
inline double beyond(float margin_m) {
  return std::nextafter(margin_m, std::numeric_limits<float>::infinity());
}

struct DistanceRange {
  float low_m, high_m;
};

// Of what separation() says, which is right to a part in 2^28. As there, what is apart is so by the
// least float32 at least.
inline DistanceRange rangeOf(double separation_m) {
  constexpr float kLeast = 1.4e-45F;
  constexpr double kError = 0x1p-27;
  return {most(kLeast, roundedDown(separation_m * (1 - kError))),
          most(kLeast, roundedUp(separation_m * (1 + kError)))};
}

}  // namespace deformable_contact_monitor
