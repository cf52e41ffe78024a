// What is certain of the distance of two bodies.
#pragma once

#include <limits>

#include "core/detector.h"

namespace deformable_contact_monitor {

enum class PairDecision {
  kNone,     // certainly farther apart than the margin
  kNear,     // certainly apart, and within margin and tolerance
  kContact,  // two points of theirs are at most the tolerance apart
  kOpen,     // none of these is certain
};

// By the rule of DESIGN's contacts within a tolerance. margin_m: of the pair.
DCM_EXPORT PairDecision decide(const BodyDistance& distance, float margin_m, float tolerance_m);

}  // namespace deformable_contact_monitor
