// Stage `output`: contacts of the working set as the result's sorted list.
#pragma once

#include <vector>

#include "core/cpu/cycle_data.h"
#include "core/cpu/pose.h"
#include "core/detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Fills result.contacts and, if scene.anyMargin(), result.separations_m; both were empty.
void writeContacts(const Scene& scene, const WorkingSet& set,
                   const std::vector<WorkingContact>& contacts, DetectionResult& result);

}  // namespace deformable_contact_monitor
