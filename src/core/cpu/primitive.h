// Defines what the CPU's stages work on: triangles at one moment (Triangle), or triangles that move
// during a time interval (MovingTriangle).
//
// The stages are templates over this type, called Primitive there. So one implementation of each
// stage serves discrete and continuous collision detection. Helpers below hide where the two
// differ: the number of states, the box type, and how far a body's boxes grow.
#pragma once

#include <type_traits>
#include <utility>

#include "core/common/scene_queries.h"
#include "core/options.h"
#include "core/predicates/swept_triangle.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

template <class Primitive>
constexpr bool kIsMoving = std::is_same_v<Primitive, MovingTriangle>;

// Number of states of a vertex (1, or 2 while it moves), and number of points that span a triangle
// in all states (3 or 6). Points of the earlier state come first.
template <class Primitive>
constexpr int kStates = kIsMoving<Primitive> ? 2 : 1;
template <class Primitive>
constexpr int kPoints = 3 * kStates<Primitive>;

// The type of a primitive's box: Aabb or MovingBox.
template <class Primitive>
using BoxOf = decltype(boxOf(std::declval<const Primitive&>()));

// Returns the mean of a primitive's points: the centroid, or, while it moves, the centroid halfway
// through the time interval. It is rounded, and is used for clustering only.
template <class Primitive>
Vec3f meanOf(const Vec3f points[kPoints<Primitive>]) {
  if constexpr (kIsMoving<Primitive>) {
    return (centroidOf(points) + centroidOf(points + 3)) * 0.5F;
  } else {
    return centroidOf(points);
  }
}

// Returns by how much a body's boxes and clusters grow [m]: the margin within which its near pairs
// are listed, or its motion bound in continuous detection, where margins do not apply.
template <class Primitive>
float growthOf(const Body& body, const Options& options) {
  return kIsMoving<Primitive> ? body.pad_m : listedMargin(body, options);
}

}  // namespace deformable_contact_monitor
