#include "moving_features.h"

#include "core/predicates/swept_exact.h"

namespace deformable_contact_monitor {

bool meetsAtStart(const Feature& feature) {
  const MovingPoint* const x = feature.x;
  PredicateState state;
  if (feature.kind == FeatureKind::kEdgeEdge) {
    return segmentsIntersect(x[0].from, x[1].from, x[2].from, x[3].from, state);
  }
  return segmentIntersectsTriangle(x[3].from, x[3].from,
                                   Triangle{{x[0].from, x[1].from, x[2].from}}, state);
}

bool meetsExactly(const Feature& feature) {
  return meetsAtStart(feature) || exactFeatureTime(feature, false).happens();
}

}  // namespace deformable_contact_monitor
