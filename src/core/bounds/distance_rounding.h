// Converts distances in double to bounds in float32 that are certainly not on the wrong side.
// Results hold distances as float32, and a bound that was rounded to the nearest one could promise
// more than is true.
#pragma once

#include <cfloat>
#include <cmath>
#include <limits>

#include "core/vector3.h"

namespace deformable_contact_monitor {

// Returns the greatest float32 that is not greater than a distance >= 0. +inf stays.
inline float roundedDown(double distance_m) {
  if (distance_m > FLT_MAX) return std::isinf(distance_m) ? INFINITY : FLT_MAX;
  const float rounded = toFloat(distance_m);
  return rounded > distance_m ? std::nextafter(rounded, 0.0F) : rounded;
}

// Returns the least float32 that is not less than a distance >= 0.
inline float roundedUp(double distance_m) {
  if (distance_m > FLT_MAX) return INFINITY;
  const float rounded = toFloat(distance_m);
  return rounded < distance_m ? std::nextafter(rounded, INFINITY) : rounded;
}

// Returns the least float32 that is greater than the margin [m]. Triangles that are at least so far
// apart are not near by nearVerdict() (predicates/narrow_phase.h) either, which rounds to nearest.
inline double beyond(float margin_m) {
  return std::nextafter(margin_m, std::numeric_limits<float>::infinity());
}

// Holds bounds of a distance [m], low_m <= high_m.
struct DistanceRange {
  float low_m, high_m;
};

// Returns bounds of the true distance from a result of separation(), whose relative error is at
// most 2^-28. Triangles that are apart have at least the least float32 as their distance.
inline DistanceRange rangeOf(double separation_m) {
  constexpr float kLeast = 1.4e-45F;
  constexpr double kError = 0x1p-27;
  return {most(kLeast, roundedDown(separation_m * (1 - kError))),
          most(kLeast, roundedUp(separation_m * (1 + kError)))};
}

}  // namespace deformable_contact_monitor
