// Scenes in two states: of the bodies' earlier states, and seeded random ones.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/predicates/swept_triangle.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// The same bodies where they were at the step's beginning, and nothing earlier.
Scene earlierScene(const Scene& scene);

// The same bodies where they are at the step's end, and nothing earlier.
Scene laterScene(const Scene& scene);

// The step backwards. A body without an earlier state has none.
Scene reversedScene(const Scene& scene);

// A step from the one scene to the other, of the same bodies and triangles; pairs, pads and margins
// are those of `to`.
Scene stepScene(const Scene& from, const Scene& to);

// Triangles with vertices of their own.
Scene movingSelfScene(const std::vector<MovingTriangle>& triangles);
Scene movingPairScene(const std::vector<MovingTriangle>& a, const std::vector<MovingTriangle>& b);

// The same seed gives the same scene on every machine. Up to three bodies of up to 14 triangles in
// all on small-integer grids, in a plane that moves or off any grid, at scales from 2^-140 to
// 2^100; segments and points in one state or in both, vertices that coincide in one state, shared
// trajectories by index and by coordinates, still triangles and bodies, steps that are small,
// common or none, poses of both states, negative zeros, huge and non-finite vertices in one state,
// random enabled pairs.
Scene randomSweptScene(std::uint32_t seed);

// Up to two bodies of small integers within [0, 8] alone, without poses: where points at a rational
// time are rational numbers with few digits.
Scene integerSweptScene(std::uint32_t seed);

// Two bodies of 300 small triangles each in a box, a few of them wide, fast or far off, on a fine
// grid or off it, with steps about as long as an edge or shorter; every pair is enabled.
Scene largeSweptScene(std::uint32_t seed);

}  // namespace deformable_contact_monitor
