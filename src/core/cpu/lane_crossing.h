// Whether triangles that cross each other's planes meet: float32 determinants of four pairs at
// once.
#pragma once

#include <cstdint>

#include "core/cpu/lane_triangle.h"

namespace deformable_contact_monitor {

// Two triangles, and on which side of the other's plane their vertices are: not all on one, none in
// the plane.
struct CrossingPair {
  const LaneTriangle *a, *b;
  PlaneSides sides_a, sides_b;
};

// A lane of a mask is set where its answer is certain.
struct LaneCrossings {
  IntLanes meet, apart;
};

// For any finite vertices.
LaneCrossings crossingsOf(const CrossingPair (&pairs)[4]);

}  // namespace deformable_contact_monitor
