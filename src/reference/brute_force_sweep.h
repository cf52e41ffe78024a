// Swept contacts of two bodies, every pair of triangles one by one.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

struct MovingBodyTriangle {
  std::uint32_t index;      // in the body's mesh
  MovingTriangle received;  // in the body's frames
  MovingTriangle moving;    // in the scene frame
};

// In ascending order of index; triangles with a vertex that is not finite in either state are left
// out. A body without an earlier state stands still. Not all where the limit was over.
std::vector<MovingBodyTriangle> movingTriangles(const Body& body, const CycleLimit& limit);

struct SweptContact {
  FirstContact first;
  bool within_pad;
};

// The verdict on one pair; nothing: no contact. Adds to candidates, exact and undecided.
std::optional<SweptContact> sweptContactOf(const MovingBodyTriangle& a, const MovingBodyTriangle& b,
                                           bool same_body, float pad_m, const Options& options,
                                           Counters& counters);

}  // namespace deformable_contact_monitor
