// The narrow phase on the device: verdicts on many pairs at once, by the text that the CPU runs.
#pragma once

#include <cstdint>
#include <vector>

#include "core/options.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

struct VerdictQuestion {
  Triangle a, b;           // scene frame [m], finite
  bool same_body = false;  // then vertices with equal coordinates are shared
};

struct BatchVerdict {
  // Words, so that no padding goes over the bus uninitialised.
  std::uint32_t contact = 0;  // 1: they are in contact
  std::uint32_t exact = 0;    // 1: the floating-point filters could not decide
  float separation_m = 0;     // of a contact; 0: they intersect
};

// One verdict per pair, in their order. `margin_m` >= 0. Throws CudaError where there is no usable
// device or a call fails.
std::vector<BatchVerdict> batchVerdicts(const std::vector<VerdictQuestion>& pairs,
                                        AdjacentPairs adjacent, Predicates predicates,
                                        float margin_m);

}  // namespace deformable_contact_monitor
