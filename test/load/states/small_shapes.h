// Distances and motions of small triangle meshes by brute force, in double. It shares nothing with
// the detectors, so that tests can judge these by it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/rigid_transform.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// A triangle mesh [m]. Triangles with a vertex that is not finite take no part in what follows.
struct SmallShape {
  std::vector<Vec3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  // Returns the share [0, 1] of triangles with a vertex that is not finite.
  double brokenShare() const;
};

Vec3d transformed(const RigidTransform& pose, const Vec3d& point);

// Returns the transform that applies `inner` first and then `outer`.
RigidTransform composed(const RigidTransform& outer, const RigidTransform& inner);

// Returns the distance of the two surfaces [m]; 0 if they intersect, and infinity if one is empty.
double distanceBetween(const SmallShape& a, const SmallShape& b);

// Returns how deep all vertices of `inner` lie within `outer` [m], which must be closed and convex;
// negative if one lies outside.
double depthWithin(const SmallShape& inner, const SmallShape& outer);

// Where the vertices of one body are at some times [0, 1] of an interval. They move on straight
// lines in between. Times ascend from 0 to 1.
struct SmallMotion {
  std::vector<double> times;
  std::vector<std::vector<Vec3d>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  SmallShape at(double time) const;
};

// Describes what happens between two bodies in an interval.
struct Encounter {
  double least_m = 0;  // the least distance, to about 1e-6 m
  // The surfaces intersect, not only in passing: also after the two have moved on by a millimetre
  // or more.
  bool is_certain = false;
};

// Finds the encounter by conservative advancement: no time is left out in which the bodies could
// touch.
Encounter encounterOf(const SmallMotion& a, const SmallMotion& b);

}  // namespace deformable_contact_monitor
