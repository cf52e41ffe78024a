// A triangle of a scene in two states, for the swept oracle.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/options.h"
#include "core/predicates/triangle.h"
#include "core/scene.h"
#include "moving_hulls.h"

namespace deformable_contact_monitor {

struct SweptTriangle {
  BodyId body;
  std::uint32_t triangle;
  std::array<Triangle, 2> received;  // body frame, state 0 and state 1
  std::array<Triangle, 2> posed;     // scene frame
};

bool isFinite(const SweptTriangle& t);

// Their hulls in the scene frame. Shared are vertices of one body that are equal as received, in
// both states.
MovingHulls hullsOf(const SweptTriangle& a, const SweptTriangle& b);

// Returns whether the oracle decides this pair: both triangles are finite, and the pair is not left
// out as vertex-adjacent.
bool isJudged(const SweptTriangle& a, const SweptTriangle& b, AdjacentPairs adjacent);

// The triangles of two scenes with the same bodies and triangles, but those that are not finite.
std::vector<SweptTriangle> sweptTriangles(const Scene& state0, const Scene& state1);

// The pairs to judge of those that the scene has enabled: closed boxes of all six points overlap.
// (body, triangle) of the first is less than that of the second; in no order.
std::vector<std::pair<const SweptTriangle*, const SweptTriangle*>> sweptBoxPairs(
    const Scene& scene, const std::vector<SweptTriangle>& triangles, AdjacentPairs adjacent);

}  // namespace deformable_contact_monitor
