// Decides the state of two bodies from bounds of their distance.
#pragma once

#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

enum class PairDecision {
  kNone,     // certainly farther apart than the margin
  kNear,     // certainly apart, and as near as margin and tolerance
  kContact,  // two of their points are at most the tolerance apart; with 0: they intersect
  kOpen,     // none of the above is certain
};

// Returns the decision that the bounds allow. `margin_m` is the margin of the pair [m]. A pair that
// was refined down to its triangles is never open: bounds that differ only by rounding count as
// equal.
DCM_EXPORT PairDecision decide(const BodyDistance& distance, float margin_m, float tolerance_m);

// Does the same with the margin that the scene gives to the two bodies, and to their parts.
DCM_EXPORT PairDecision decide(const BodyDistance& distance, const Scene& scene, float tolerance_m);

// Returns "none", "near", "contact", "unknown".
DCM_EXPORT const char* toString(PairDecision decision);

}  // namespace deformable_contact_monitor
