// Which triangles take no part for a vertex that is not finite.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/options.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

struct RejectedTriangles {
  std::size_t count = 0;  // of the body's triangles; what Counters::rejected sums up
  bool by_pose = false;   // a pose makes some vertex infinite that was received finite
};

// One per body of the scene; zero for those that take no part. In swept motion, of both states.
// Looks at every vertex: worth it only where a cycle rejected any.
std::vector<RejectedTriangles> rejectedTriangles(const Scene& scene,
                                                 Motion motion = Motion::kInstant);

}  // namespace deformable_contact_monitor
