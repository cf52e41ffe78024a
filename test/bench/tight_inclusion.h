// Tight-Inclusion (Wang et al., "A Large-scale Benchmark and an Inclusion-based Algorithm for
// Continuous Collision Detection", 2021) on a vertex and a face, or two edges, that move.
#pragma once

#include "core/predicates/swept_feature.h"

namespace deformable_contact_monitor {

// Calls it as its users do: breadth first, to 1e-6, at most a million steps.
bool meetsByTightInclusion(const Feature& feature);

}  // namespace deformable_contact_monitor
