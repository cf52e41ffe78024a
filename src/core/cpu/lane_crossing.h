// Decides whether triangles that cross each other's planes meet, by two float32 determinants, for
// four pairs at once.
#pragma once

#include "core/cpu/lane_triangle.h"

namespace deformable_contact_monitor {

// Two triangles that share no vertex, and on which side of the other's plane their vertices lie.
// Not all of a triangle's vertices are on one side, and none is in the plane.
struct CrossingPair {
  const LaneTriangle *a, *b;
  PlaneSides sides_a, sides_b;
};

// A lane of a mask is set where that answer is certain.
struct LaneCrossings {
  IntLanes meet, apart;
};

// Decides four pairs. Vertices must be finite.
LaneCrossings crossingsOf(const CrossingPair (&pairs)[4]);

}  // namespace deformable_contact_monitor
