// Defines which pairs of triangles belong to one of several devices.
#pragma once

#include <cmath>

#include "core/predicates/aabb.h"
#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

// A slab of the scene between two planes across an axis: [low, high) [m]. A pair whose boxes meet
// belongs to the slab where the intersection of the two boxes begins. That place lies within both
// boxes. So slabs that fill the line contain each such pair exactly once, and a partition needs
// only triangles whose boxes reach into its slab. All devices must compute the same bits for the
// boxes; they need not agree on anything else.
struct ScenePartition {
  int axis = 0;  // 0, 1, 2: x, y, z
  float low = -INFINITY, high = INFINITY;

  DCM_HD bool isWhole() const { return low == -INFINITY && high == INFINITY; }

  // Returns whether no other slab is below this one.
  bool isFirst() const { return low == -INFINITY; }

  DCM_HD bool has(const Vec3f& point) const { return has(point[axis]); }

  // Return whether the whole box lies above or below the slab.
  DCM_HD bool isAbove(const Aabb& box) const { return box.min[axis] >= high; }
  DCM_HD bool isBelow(const Aabb& box) const { return box.max[axis] < low; }

  // Returns whether a triangle with this box may have a pair here.
  DCM_HD bool reaches(const Aabb& box) const { return !isBelow(box) && !isAbove(box); }

  // Returns whether a pair of triangles belongs here; their boxes must meet.
  DCM_HD bool owns(const Aabb& a, const Aabb& b) const {
    return has(most(a.min[axis], b.min[axis]));
  }

 private:
  DCM_HD bool has(float place) const { return low <= place && place < high; }
};

// Returns the box of a moving triangle for ScenePartition::owns(): it contains both states, grown
// by four times `pad_m`, the pad of its body [m]. The factor four leaves room for rounding, because
// the pads of two bodies are added and rounded before they are compared. A product by four is
// exact, so the box has the same bits whether or not the compiler contracts the operations.
DCM_HD inline Aabb partitionBox(const MovingBox& box, float pad_m) {
  Aabb both = box.from;
  both.include(box.to);
  return inflated(both, 4 * pad_m);
}

}  // namespace deformable_contact_monitor
