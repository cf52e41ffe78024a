// Features of triangles in two states, decided exactly.
#pragma once

#include "core/predicates/swept_feature.h"

namespace deformable_contact_monitor {

// Returns whether the feature meets at t = 0.
bool meetsAtStart(const Feature& feature);

// Returns whether the feature meets at any time of the interval. It uses integers and no filters.
bool meetsExactly(const Feature& feature);

}  // namespace deformable_contact_monitor
