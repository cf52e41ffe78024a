// Scaled coordinates for clustering and projection, and the rule for oversized triangles. Verdicts
// never use scaled coordinates.
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/predicates/aabb.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Maps v to (v - origin) * scale. The scale of clusters is a power of two that brings the working
// set into [-1, 1]. It computes in double: the scale of a subnormal scene is no float32.
struct SceneScale {
  Vec3d origin;
  double scale = 1;

  DCM_HD Vec3d applyExact(const Vec3d& v) const { return (v - origin) * scale; }
  // Each coordinate of the result has an error of less than kScaledError times its size.
  DCM_HD Vec3f apply(const Vec3f& v) const { return toFloat(applyExact(toDouble(v))); }
  DCM_HD Vec3d invert(const Vec3f& s) const { return toDouble(s) * (1 / scale) + origin; }
};

// 2^-24 for the rounding to float32, and some room for the rounding in double.
constexpr float kScaledError = 6.0e-8F;

// The rule that separates oversized triangles: those that are very large or far away. One such
// outlier must cost only itself. In clusters it would stretch the coordinates, rotate the principal
// axes and be everywhere. So it goes to a list of its own, whose triangles are tested by boxes
// (stage `oversized`). A new rule calls every triangle regular.
struct SizeRule {
  Vec3d origin;                                          // the middle of the scene [m]
  double most_extent = INFINITY, most_reach = INFINITY;  // [m]
};

// The rule in float32, for many triangles. Rounding does not matter here.
struct SizeBounds {
  Aabb within{{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};  // [m]
  float most_extent = INFINITY;                                                    // [m]

  SizeBounds() = default;
  explicit SizeBounds(const SizeRule& rule)
      : within{around(rule, -rule.most_reach), around(rule, rule.most_reach)},
        most_extent(toFloat(rule.most_extent)) {}

  // `box`: that of a triangle, which must not be empty.
  DCM_HD bool isOversized(const Aabb& box) const {
    const Vec3f size = box.max - box.min;
    return most(size.x, most(size.y, size.z)) > most_extent || box.min.x < within.min.x ||
           box.min.y < within.min.y || box.min.z < within.min.z || box.max.x > within.max.x ||
           box.max.y > within.max.y || box.max.z > within.max.z;
  }

 private:
  static Vec3f around(const SizeRule& rule, double reach) {
    return toFloat(rule.origin + Vec3d{reach, reach, reach});
  }
};

}  // namespace deformable_contact_monitor
