// What the stages work on: triangles at one moment (Triangle), or in the step between two
// (MovingTriangle). The stages are templates over the two.
#pragma once

#include <type_traits>
#include <utility>

#include "core/predicates/swept_triangle.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

template <class Hull>
constexpr bool kIsMoving = std::is_same_v<Hull, MovingTriangle>;

// How many places a vertex has, and a triangle has vertices in: where it was comes first.
template <class Hull>
constexpr int kStates = kIsMoving<Hull> ? 2 : 1;
template <class Hull>
constexpr int kPoints = 3 * kStates<Hull>;

// Aabb or MovingBox.
template <class Hull>
using BoxOf = decltype(boxOf(std::declval<const Hull&>()));

// Of a hull's points: the centroid, of what moves halfway; rounded.
template <class Hull>
Vec3f meanOf(const Vec3f points[kPoints<Hull>]) {
  if constexpr (kIsMoving<Hull>) {
    return (centroidOf(points) + centroidOf(points + 3)) * 0.5F;
  } else {
    return centroidOf(points);
  }
}

// By what a body's boxes and clusters grow [m]: swept motion knows no margins, but pads.
template <class Hull>
float growthOf(const Body& body) {
  return kIsMoving<Hull> ? body.pad_m : body.margin_m;
}

}  // namespace deformable_contact_monitor
