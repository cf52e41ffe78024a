// How bodies' margins act on pairs and on clusters.
#pragma once

#include <cmath>

#include "core/predicates/host_device.h"
#include "core/predicates/vector3.h"
#include "core/rules/scene_scale.h"

namespace deformable_contact_monitor {

// A pair of bodies counts at a distance <= the larger of its two margins [m].
DCM_HD inline float pairMargin(float margin_a_m, float margin_b_m) {
  return most(margin_a_m, margin_b_m);
}

// Slack of the half-space rule for a body with this margin [scaled]: twice the margin, rounded
// upwards. Each body is inflated by its full own margin.
inline float scaledSlack(float margin_m, const SceneScale& scale) {
  const double margin = margin_m * scale.scale;
  return margin > 0 ? std::nextafter(static_cast<float>(2 * margin), INFINITY) : 0.0F;
}

}  // namespace deformable_contact_monitor
