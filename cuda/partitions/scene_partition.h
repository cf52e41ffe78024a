// Which pairs of triangles one of several devices is there for.
#pragma once

#include <cmath>

#include "core/predicates/aabb.h"
#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

// A slab of the scene across an axis, [low, high). A pair whose boxes meet belongs to the slab
// where the intersection of its boxes begins: a place within both boxes. So shares whose slabs fill
// the line have each such pair once, and a share needs those triangles alone whose boxes reach into
// its slab. All devices must have the same bits of the boxes, and nothing else, in common.
struct SceneShare {
  int axis = 0;  // x, y, z
  float low = -INFINITY, high = INFINITY;

  DCM_HD bool isWhole() const { return low == -INFINITY && high == INFINITY; }

  DCM_HD bool has(const Vec3f& point) const { return has(point[axis]); }

  // Whether all that has this box is on one side of the slab.
  DCM_HD bool isAbove(const Aabb& box) const { return box.min[axis] >= high; }
  DCM_HD bool isBelow(const Aabb& box) const { return box.max[axis] < low; }

  // Whether a triangle with this box may have a pair here.
  DCM_HD bool reaches(const Aabb& box) const { return !isBelow(box) && !isAbove(box); }

  // Whether a pair of triangles whose boxes, these, meet belongs here.
  DCM_HD bool owns(const Aabb& a, const Aabb& b) const {
    return has(most(a.min[axis], b.min[axis]));
  }

 private:
  DCM_HD bool has(float place) const { return low <= place && place < high; }
};

// For the rule above, in swept motion: of all that a triangle passes, `pad_m` being its body's.
// Four times that, for pads of two bodies are added up and rounded before anything is compared with
// them; a product by four is the same bits wherever it is contracted.
DCM_HD inline Aabb shareBox(const MovingBox& box, float pad_m) {
  Aabb both = box.from;
  both.include(box.to);
  return inflated(both, 4 * pad_m);
}

}  // namespace deformable_contact_monitor
