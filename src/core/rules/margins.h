// How bodies' margins and pads act on pairs and on clusters.
#pragma once

#include <cfloat>
#include <cmath>

#include "core/host_device.h"
#include "core/rules/scene_scale.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// A pair of bodies counts at a distance <= the larger of its two margins [m].
DCM_HD inline float pairMargin(float margin_a_m, float margin_b_m) {
  return most(margin_a_m, margin_b_m);
}

// In swept motion: points of two bodies with these pads are at most this much nearer to each other
// than on their straight ways [m]. Rounded up.
DCM_HD inline float pairPad(float pad_a_m, float pad_b_m) {
  const float sum = pad_a_m + pad_b_m;
  return pad_a_m == 0 || pad_b_m == 0 ? sum : least(nextafterf(sum, INFINITY), FLT_MAX);
}

// Slack of the half-space rule for a body with this margin or pad [scaled]: twice the margin and a
// little more, for distances are rounded before they are compared with it. Each body is inflated by
// its full own margin.
inline float scaledSlack(float margin_m, const SceneScale& scale) {
  constexpr double kMore = 1 + 1e-6;
  const double slack = 2 * (margin_m * scale.scale) * kMore;
  return slack > 0 ? std::nextafter(static_cast<float>(least<double>(slack, FLT_MAX)), INFINITY)
                   : 0.0F;
}

// What a body's boxes and clusters grow by in swept motion [m]: its pad and a little more, for pads
// of two bodies are added up before they are compared with anything.
inline float grownPad(float pad_m) { return pad_m * (1 + 1e-6F); }

}  // namespace deformable_contact_monitor
