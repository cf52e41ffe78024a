// Rules on how bodies' margins and motion bounds apply to pairs and to clusters.
#pragma once

#include <cfloat>
#include <cmath>

#include "core/host_device.h"
#include "core/rules/scene_scale.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Returns the margin of a pair of bodies: the larger of their margins [m].
DCM_HD inline float pairMargin(float margin_a_m, float margin_b_m) {
  return most(margin_a_m, margin_b_m);
}

// Returns the motion bound of a pair of bodies: points of the two are at most this much nearer to
// each other than on their straight lines [m]. It is rounded up.
DCM_HD inline float pairPad(float pad_a_m, float pad_b_m) {
  const float sum = pad_a_m + pad_b_m;
  return pad_a_m == 0 || pad_b_m == 0 ? sum : least(nextafterf(sum, INFINITY), FLT_MAX);
}

// Returns the slack of the half-space rule for a body with this margin or motion bound [scaled]:
// twice the margin and a little more, because distances are rounded to float32 before they are
// compared with it. Each body is inflated by its full own margin.
inline float scaledSlack(float margin_m, const SceneScale& scale) {
  if (margin_m == 0) return 0;
  constexpr double kMore = 1 + 1e-6, kLeastStep = 0x1p-149;
  const double slack = 2 * ((margin_m * kMore + kLeastStep) * scale.scale);
  return slack > 0 ? std::nextafter(toFloat(least<double>(slack, FLT_MAX)), INFINITY) : 0.0F;
}

// Returns by how much a body's boxes and clusters grow in continuous detection [m]: its motion
// bound and a little more, because bounds of two bodies are added before they are compared.
inline float grownPad(float pad_m) { return pad_m * (1 + 1e-6F); }

}  // namespace deformable_contact_monitor
