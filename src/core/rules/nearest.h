// The rule by which the nearest triangles of two bodies are chosen, and how bounds of distances
// tell which pairs of triangles need no look.
//
// separation() is right to 2^-28 of itself, and is then rounded to float32. So a pair whose true
// distance is at least `low_m` has a float32 distance of at least leastCompared(low_m). A pair is
// left out only if that is more than the best pair's distance, or equal to it while its triangles
// come later. Bounds must not be rounded up.
#pragma once

#include <cfloat>
#include <cstdint>

#include "core/host_device.h"
#include "core/predicates/triangle_distance.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Returns separation() of two triangles as the float32 by which pairs are compared [m]. It is never
// 0, which is for triangles that intersect, and never infinite.
DCM_HD inline float comparedDistance(double separation_m) {
  constexpr float kLeast = 1.4e-45F;
  return most(kLeast, toFloat(least<double>(separation_m, FLT_MAX)));
}

// Two triangles of two bodies, and how far they are apart.
struct ComparedPair {
  float distance_m;  // comparedDistance(), or 0 if they intersect
  std::uint32_t triangle_a, triangle_b;

  // Returns whether this pair is nearer, or as near and its triangles come first.
  DCM_HD bool precedes(const ComparedPair& o) const {
    if (distance_m != o.distance_m) return distance_m < o.distance_m;
    return triangle_a != o.triangle_a ? triangle_a < o.triangle_a : triangle_b < o.triangle_b;
  }
};

// The largest relative error of separation(), and of the double arithmetic on a bound of it.
constexpr double kSeparationError = 0x1p-28 * (1 + 1e-6);

// Returns the least comparedDistance() that a pair of triangles may have whose distance is at least
// low_m >= 0 [m]; 0 if they may intersect.
DCM_HD inline float leastCompared(double low_m) {
  return low_m > 0 ? comparedDistance(low_m * (1 - kSeparationError)) : 0;
}

// Returns a distance [m] such that pairs at least so far apart have a comparedDistance() above
// distance_m: +inf if there are none such.
DCM_HD inline double certainlyBeyond(float distance_m) {
  // Rounding to nearest takes what is not nearer than this to the next float32 or beyond.
  return static_cast<double>(nextafterf(distance_m, INFINITY)) * (1 + 2 * kSeparationError);
}

// Returns a distance [m] such that pairs at least so far apart have a comparedDistance() of at
// least distance_m. It is about half a step of float32 below that.
DCM_HD inline double certainlyNotBelow(float distance_m) {
  const double middle = (static_cast<double>(nextafterf(distance_m, 0)) + distance_m) / 2;
  return middle * (1 + 4 * kSeparationError);
}

}  // namespace deformable_contact_monitor
