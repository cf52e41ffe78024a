// FCL's bounding volume hierarchies behind the detector's interface, for comparison: its triangle
// test works in floating point, so its pairs may differ from the exact ones (`guaranteed` is always
// false). It cannot tell whether triangles that share a vertex meet beyond it, so such pairs are
// left out whatever `adjacent` says. Margins are ignored, all separations are 0; one thread.
#pragma once

#include <memory>

#include "core/detector.h"

namespace deformable_contact_monitor {

std::unique_ptr<Detector> makeFclDetector();

}  // namespace deformable_contact_monitor
