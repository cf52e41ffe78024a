// On which sides of a box points certainly are: one byte says for three of them that they, and so
// their triangle, miss it.
#pragma once

#include <cfloat>
#include <cmath>
#include <cstdint>

#include "core/predicates/aabb.h"

namespace deformable_contact_monitor {

// Of a closed box, and points that are grown by `growth_m` >= 0, as inflated() grows boxes: where
// three of them have a bit in common, the box of the three, grown, does not intersect this one.
// The other way round some that are next to it may have none. Points are finite.
class BoxSides {
 public:
  BoxSides(const Aabb& box, float growth_m)
      : low_{largestBelow(box.min.x, growth_m), largestBelow(box.min.y, growth_m),
             largestBelow(box.min.z, growth_m)},
        high_{-largestBelow(-box.max.x, growth_m), -largestBelow(-box.max.y, growth_m),
              -largestBelow(-box.max.z, growth_m)} {}

  // Single | on purpose: no branches.
  std::uint8_t of(const Vec3f& p) const {
    return static_cast<std::uint8_t>((p.x <= low_.x) | (p.x >= high_.x) << 1 |
                                     (p.y <= low_.y) << 2 | (p.y >= high_.y) << 3 |
                                     (p.z <= low_.z) << 4 | (p.z >= high_.z) << 5);
  }

 private:
  // All up to it stay below `bound`, grown; nearly the largest for which this holds.
  static float largestBelow(float bound, float growth_m) {
    const float x = bound - growth_m - 4e-7F * (std::fabs(bound) + growth_m) - FLT_MIN;
    return inflated(Aabb{{x, x, x}, {x, x, x}}, growth_m).max.x < bound ? x : -INFINITY;
  }

  Vec3f low_, high_;
};

}  // namespace deformable_contact_monitor
