// Stage `large`: the pairs that a large triangle is part of.
#pragma once

#include "core/cpu/cycle_data.h"

namespace deformable_contact_monitor {

// Tests each large triangle by boxes against the clusters and, where they meet, their members; and
// the large ones against each other, by a sweep along x. Adds to `output`, until the limit is over.
// Hull: as in hull.h.
template <class Hull>
void sweepLargeTriangles(const CycleInput<Hull>& input, CycleOutput<Hull>& output);

}  // namespace deformable_contact_monitor
