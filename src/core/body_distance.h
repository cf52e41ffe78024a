// Decides the state of two bodies from bounds of their distance.
#pragma once

#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

// What bounds say of two bodies whose distance lies in [low, high]; m is the margin of the pair, t
// the tolerance, all in [m].
enum class PairDecision {
  kNone,     // low > m: they are farther apart than the margin
  kNear,     // no contact, low > 0, high <= m + t and high - low <= t: they are apart, and near
  kContact,  // low <= m and high <= t: two points are at most t apart; with t = 0 they intersect
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
