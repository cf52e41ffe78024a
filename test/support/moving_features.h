// Features of triangles in two states, decided exactly.
#pragma once

#include "core/predicates/swept_feature.h"

namespace deformable_contact_monitor {

// Whether it meets at t = 0.
bool meetsAtStart(const Feature& feature);

// Whether it meets at any time of the step: without filters, by integers.
bool meetsExactly(const Feature& feature);

}  // namespace deformable_contact_monitor
