// The powers of fuzzy c-means (Bezdek 1981).
#pragma once

#include <cmath>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// What the fuzzifier m asks for: w = (d_min^2 / d^2)^(1 / (m - 1)) and u^m.
struct FuzzyPowers {
  float m = 2;

  // `ratio` in [0, 1].
  DCM_HD float weight(float ratio) const { return powf(ratio, 1 / (m - 1)); }
  // `u` in [0, 1].
  DCM_HD float power(float u) const { return powf(u, m); }
};

}  // namespace deformable_contact_monitor
