// Whether a result can be taken as all there is.
#pragma once

#include "core/detector.h"

namespace deformable_contact_monitor {

// Every triangle took part, no contact was left out and nothing was cut off.
inline bool isWhole(const DetectionResult& result) {
  return result.counters.rejected == 0 && result.left_out == 0 && !result.cut_off;
}

// That, and the settings are complete by proof.
inline bool isComplete(const DetectionResult& result) {
  return result.guaranteed && isWhole(result);
}

}  // namespace deformable_contact_monitor
