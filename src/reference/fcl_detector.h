// Puts FCL (the Flexible Collision Library) behind the detector's interface, for comparison.
// Benchmarks compare its speed, and tests its distances, with ours.
#pragma once

#include <memory>

#include "core/detector.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// Returns a detector that uses FCL's bounding volume hierarchies. Its triangle test works in
// floating point, so that its pairs may differ from the exact ones (`guaranteed` is always false).
// It cannot tell whether triangles that share a vertex meet beyond it, so that it leaves out such
// pairs for all values of `adjacent`. Margins are ignored, and all separations are 0. It uses one
// thread.
std::unique_ptr<Detector> makeFclDetector();

// Where two triangles are closest, as FCL computes it: in double, with rounding.
struct FclClosestPoints {
  Vec3d on_a, on_b;
  double distance = 0;  // [m]
};

// Returns the closest points of triangles that do not intersect. FCL ignores faces whose doubled
// area is below 3.2e-8 m2: for such small triangles it may return a distance of 0 although they are
// apart.
FclClosestPoints fclClosestPoints(const Triangle& a, const Triangle& b);

}  // namespace deformable_contact_monitor
