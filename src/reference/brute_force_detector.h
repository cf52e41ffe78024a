// Every pair of triangles, one by one, with the same predicates and margins: slow and simple.
#pragma once

#include <memory>

#include "core/detector.h"

namespace deformable_contact_monitor {

std::unique_ptr<Detector> makeBruteForceDetector();

}  // namespace deformable_contact_monitor
