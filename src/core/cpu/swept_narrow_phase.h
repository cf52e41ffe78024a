// Stage `judge` between two states.
#pragma once

#include <vector>

#include "core/cpu/cycle_data.h"

namespace deformable_contact_monitor {

// Adds the contacts among the candidates to `output`, with their first times if
// options.first_times, until the limit is over.
void judgeCandidates(const CycleInput<MovingTriangle>& input,
                     const Screened<MovingTriangle>& screened, CycleOutput<MovingTriangle>& output);

}  // namespace deformable_contact_monitor
