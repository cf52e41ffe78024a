// What is certain of the distance of two bodies.
#pragma once

#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

enum class PairDecision {
  kNone,     // certainly farther apart than the margin
  kNear,     // certainly apart, and within margin and tolerance
  kContact,  // two points of theirs are at most the tolerance apart; with 0: they intersect
  kOpen,     // none of these is certain
};

// By the rules beside PairDecision's values. margin_m: of the pair. A pair that was
// looked at down to its triangles is never open: where high_m and low_m differ by rounding alone,
// they count as equal.
DCM_EXPORT PairDecision decide(const BodyDistance& distance, float margin_m, float tolerance_m);

// "none", "near", "contact", "unknown".
DCM_EXPORT const char* toString(PairDecision decision);

}  // namespace deformable_contact_monitor
