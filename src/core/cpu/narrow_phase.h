// Stage `judge`: the verdict on each candidate.
#pragma once

#include "core/cpu/cycle_data.h"

namespace deformable_contact_monitor {

// Counts the candidates and adds those that are contacts to `output`, until the limit is over.
void judgeCandidates(const CycleInput<Triangle>& input, const Screened<Triangle>& screened,
                     CycleOutput<Triangle>& output);

}  // namespace deformable_contact_monitor
