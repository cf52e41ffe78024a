// What the radii of two bodies make of the distance of their triangles.
#pragma once

#include <algorithm>
#include <cfloat>

#include "core/bounds/distance_rounding.h"
#include "core/detector.h"
#include "core/scene.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Returns the nearest float32 that is finite.
inline float finiteFloat(double x) {
  return static_cast<float>(std::clamp<double>(x, -FLT_MAX, FLT_MAX));
}

// Returns the point that is by_m farther along a direction.
inline Vec3f movedAlong(const Vec3f& direction, double by_m, const Vec3f& point) {
  return {finiteFloat(point.x + by_m * direction.x), finiteFloat(point.y + by_m * direction.y),
          finiteFloat(point.z + by_m * direction.z)};
}

// The radii of a pair of bodies.
struct PairRadii {
  double a_m, b_m;
  float touch_m;  // at most so far apart, their triangles are a contact

  PairRadii(const Body& a, const Body& b)
      : a_m(a.radius_m), b_m(b.radius_m), touch_m(roundedDown(a_m + b_m)) {}

  double sum() const { return a_m + b_m; }

  // Returns the distance of the two, from that of the triangles; 0 if they touch. It never falls
  // when that of the triangles grows.
  float apartM(float distance_m) const {
    if (distance_m <= touch_m) return 0;
    return std::max(static_cast<float>(distance_m - sum()), FLT_TRUE_MIN);
  }

  // Returns a distance of the triangles beyond which apartM() is certainly more than this.
  float triangleDistanceM(float apart_m) const {
    if (apart_m == 0 || sum() == 0) return most(apart_m, touch_m);
    return roundedUp(std::min<double>((apart_m + sum()) * (1 + 0x1p-22), FLT_MAX));
  }
};

// Moves the closest points of two triangles, which are gap_m apart along the normal, to the
// surfaces of the bodies; or both to the middle of the overlap if the bodies touch.
inline void movePoints(const PairRadii& radii, double gap_m, const Vec3f& normal, bool touch,
                       Vec3f* a, Vec3f* b) {
  if (!touch) {
    *a = movedAlong(normal, radii.a_m, *a);
    *b = movedAlong(normal, -radii.b_m, *b);
    return;
  }
  // Along the normal, from point_a on, a reaches from -a_m to a_m, and b from gap - b_m to gap +
  // b_m.
  const double from_m = std::max(-radii.a_m, gap_m - radii.b_m);
  const double to_m = std::min(radii.a_m, gap_m + radii.b_m);
  *a = movedAlong(normal, (from_m + to_m) / 2, *a);
  *b = *a;
}

// Takes the radii off a nearest pair, which is that of the triangles.
inline void deflate(const PairRadii& radii, NearestPair* nearest) {
  if (radii.sum() == 0) return;
  const double gap_m = nearest->distance_m;
  nearest->distance_m = radii.apartM(nearest->distance_m);
  const bool touch = nearest->distance_m == 0;
  movePoints(radii, gap_m, nearest->normal, touch, &nearest->point_a, &nearest->point_b);
  if (touch) nearest->normal = Vec3f();
}

}  // namespace deformable_contact_monitor
