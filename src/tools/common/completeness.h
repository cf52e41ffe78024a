// Whether a result can be taken as all there is.
#pragma once

#include "core/detector.h"

namespace deformable_contact_monitor {

// The settings are complete by proof, every triangle took part and no contact was left out.
inline bool isComplete(const DetectionResult& result) {
  return result.guaranteed && result.counters.rejected == 0 && result.left_out == 0 &&
         !result.cut_off;
}

}  // namespace deformable_contact_monitor
