// The common motion of a scene, which is taken off in continuous detection.
//
// Any translation may be subtracted from all vertices at the end of the time interval: contacts
// stay the same. So bodies that travel together have boxes as small as if they stood still. This is
// done for boxes, clusters and intervals, which are rounded outwards; verdicts use the vertices as
// they are.
#pragma once

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/predicates/swept_triangle.h"
#include "core/rules/scene_scale.h"

namespace deformable_contact_monitor {

// Returns the box of all points of `box` moved back by `motion`, in real numbers. A box that would
// reach beyond the largest float32 ends there; boxes that overlapped still do.
DCM_HD inline Aabb withoutMotion(const Aabb& box, const Vec3f& motion) {
  const auto down = [](float x, float m) {
    return m == 0 ? x : most(nextafterf(x - m, -INFINITY), -FLT_MAX);
  };
  const auto up = [](float x, float m) {
    return m == 0 ? x : least(nextafterf(x - m, INFINITY), FLT_MAX);
  };
  return {{down(box.min.x, motion.x), down(box.min.y, motion.y), down(box.min.z, motion.z)},
          {up(box.max.x, motion.x), up(box.max.y, motion.y), up(box.max.z, motion.z)}};
}

// Returns the box of all points that the content passes, without the common motion.
DCM_HD inline Aabb sweptBox(const MovingBox& box, const Vec3f& motion) {
  return sweptBox(MovingBox{box.from, withoutMotion(box.to, motion)});
}

// Returns the scale for points at the end of the time interval.
DCM_HD inline SceneScale withoutMotion(SceneScale scale, const Vec3f& motion) {
  scale.origin = scale.origin + toDouble(motion);
  return scale;
}

// Returns the median of the motions of a sample of vertices [m], or 0 if the motions are usually no
// nearer to it than to 0. Reorders the sample, which must not contain NaN.
inline Vec3f commonMotion(std::vector<Vec3d>& motions) {
  if (motions.empty()) return {};
  const auto middle = [&motions](const auto& value) {
    const auto at = motions.begin() + static_cast<std::ptrdiff_t>(motions.size() / 2);
    std::nth_element(motions.begin(), at, motions.end(),
                     [&value](const Vec3d& a, const Vec3d& b) { return value(a) < value(b); });
    return value(*at);
  };
  const Vec3f common = toFloat({middle([](const Vec3d& m) { return m.x; }),
                                middle([](const Vec3d& m) { return m.y; }),
                                middle([](const Vec3d& m) { return m.z; })});
  if (!isFinite(common)) return {};
  const auto size = [](const Vec3d& m) {
    return std::max({std::fabs(m.x), std::fabs(m.y), std::fabs(m.z)});
  };
  const double with = middle(size);
  const double without = middle([&](const Vec3d& m) { return size(m - toDouble(common)); });
  return 2 * without < with ? common : Vec3f();
}

}  // namespace deformable_contact_monitor
