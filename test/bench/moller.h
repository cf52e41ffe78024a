// The triangle-triangle test of T. Moeller, "A Fast Triangle-Triangle Intersection Test" (1997), in
// float32 with its customary absolute tolerance: what many engines run, for comparison.
#pragma once

#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

bool mollerIntersects(const Triangle& a, const Triangle& b);

}  // namespace deformable_contact_monitor
