// Axis-aligned bounding boxes of float32 points [m]. They are closed, and never rounded inwards:
// whatever a box was made of lies inside it.
#pragma once

#include <cfloat>
#include <cmath>

#include "core/host_device.h"
#include "core/predicates/triangle.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// A closed box. A new one is empty and intersects nothing.
struct Aabb {
  Vec3f min{INFINITY, INFINITY, INFINITY};
  Vec3f max{-INFINITY, -INFINITY, -INFINITY};

  DCM_HD void include(const Vec3f& p) {
    min = {least(min.x, p.x), least(min.y, p.y), least(min.z, p.z)};
    max = {most(max.x, p.x), most(max.y, p.y), most(max.z, p.z)};
  }
  DCM_HD void include(const Aabb& o) {
    min = {least(min.x, o.min.x), least(min.y, o.min.y), least(min.z, o.min.z)};
    max = {most(max.x, o.max.x), most(max.y, o.max.y), most(max.z, o.max.z)};
  }
  DCM_HD bool empty() const { return !(min.x <= max.x); }
};

// Returns whether two boxes intersect; touching counts. It uses & instead of && because the
// comparisons are cheaper than branches.
DCM_HD inline bool intersects(const Aabb& a, const Aabb& b) {
  return (a.min.x <= b.max.x) & (b.min.x <= a.max.x) & (a.min.y <= b.max.y) & (b.min.y <= a.max.y) &
         (a.min.z <= b.max.z) & (b.min.z <= a.max.z);
}

// Returns the smallest box of a triangle.
DCM_HD inline Aabb boxOf(const Triangle& t) {
  Aabb box{t.v[0], t.v[0]};
  box.include(t.v[1]);
  box.include(t.v[2]);
  return box;
}

// Returns the box grown by `distance` >= 0 [m] in every direction, rounded outwards; 0 leaves it
// unchanged. It ends at the largest float32, beyond which no vertex lies.
DCM_HD inline Aabb inflated(const Aabb& box, float distance) {
  if (distance == 0) return box;
  const auto down = [distance](float x) {
    return most(nextafterf(x - distance, -INFINITY), -FLT_MAX);
  };
  const auto up = [distance](float x) {
    return least(nextafterf(x + distance, INFINITY), FLT_MAX);
  };
  return {{down(box.min.x), down(box.min.y), down(box.min.z)},
          {up(box.max.x), up(box.max.y), up(box.max.z)}};
}

// Returns whether high - low > distance in real numbers, although the difference is rounded.
DCM_HD inline bool exceeds(float high, float low, float distance) {
  const double gap = static_cast<double>(high) - low;
  if (gap != distance) return gap > distance;
  const double part = high - gap;  // what rounding took off the gap (Knuth's two-sum)
  return (high - (gap + part)) + (part - low) > 0;
}

// Returns whether the boxes are more than `distance` apart along some axis, in real numbers. If
// they are not, each of them, inflated by `distance`, meets the other.
DCM_HD inline bool areApart(const Aabb& a, const Aabb& b, float distance) {
  return exceeds(b.min.x, a.max.x, distance) || exceeds(a.min.x, b.max.x, distance) ||
         exceeds(b.min.y, a.max.y, distance) || exceeds(a.min.y, b.max.y, distance) ||
         exceeds(b.min.z, a.max.z, distance) || exceeds(a.min.z, b.max.z, distance);
}

// Returns the squared distance of two boxes [m^2], in double; 0 if they intersect.
DCM_HD inline double squaredGap(const Aabb& a, const Aabb& b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double above = static_cast<double>(b.min[k]) - a.max[k];
    const double below = static_cast<double>(a.min[k]) - b.max[k];
    const double gap = most(most(above, below), 0.0);
    sum += gap * gap;
  }
  return sum;
}

}  // namespace deformable_contact_monitor
