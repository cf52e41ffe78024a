#include "core/body_distance.h"

#include <algorithm>
#include <cmath>

#include "core/rules/margins.h"

namespace deformable_contact_monitor {

PairDecision decide(const BodyDistance& distance, float margin_m, float tolerance_m) {
  // The largest difference between a distance rounded upwards and the same rounded downwards: a
  // part of it, or four times the least float32.
  constexpr float kRounding = 0x1p-20F, kLeastRounding = 6e-45F;
  if (distance.low_m > margin_m) return PairDecision::kNone;
  if (distance.high_m <= tolerance_m) return PairDecision::kContact;
  if (distance.is_exact) {
    return std::isfinite(distance.high_m) ? PairDecision::kNear : PairDecision::kNone;
  }
  // Listed contacts were decided by nearVerdict() (predicates/narrow_phase.h).
  if (distance.is_listed) {
    return distance.contact_count > 0 ? PairDecision::kNear : PairDecision::kNone;
  }
  const float slack = std::max({tolerance_m, distance.high_m * kRounding, kLeastRounding});
  if (distance.low_m > 0 && distance.high_m - slack <= margin_m &&
      distance.high_m - distance.low_m <= slack) {
    return PairDecision::kNear;
  }
  return PairDecision::kOpen;
}

PairDecision decide(const BodyDistance& distance, const Scene& scene, float tolerance_m) {
  const Body &a = scene.body(distance.body_a), &b = scene.body(distance.body_b);
  const PairDecision decision = decide(distance, pairMargin(a.margin_m, b.margin_m), tolerance_m);
  if (decision != PairDecision::kNear || distance.is_exact || distance.is_listed) return decision;
  // The two points are near if the parts that they lie on have such a margin.
  const float margin_m = pairMargin(a.marginOf(a.partOf(distance.witness.triangle_a)),
                                    b.marginOf(b.partOf(distance.witness.triangle_b)));
  return decide(distance, margin_m, tolerance_m) == PairDecision::kNear ? decision
                                                                        : PairDecision::kOpen;
}

const char* toString(PairDecision decision) {
  constexpr const char* kNames[] = {"none", "near", "contact", "unknown"};
  return kNames[static_cast<std::size_t>(decision)];
}

}  // namespace deformable_contact_monitor
