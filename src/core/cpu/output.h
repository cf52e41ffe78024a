// Stage `output`: contacts of the working set as the result's sorted list.
#pragma once

#include "core/cpu/contact_list.h"
#include "core/cpu/pose.h"
#include "core/cycle_limit.h"
#include "core/detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Fills result.contacts, result.left_out and, if scene.anyMargin(), result.separations_m; all
// were empty. Once the limit is over, no more contacts than are sorted in little time: then
// others are left out, and the result says that it was cut off.
void writeContacts(const Scene& scene, const WorkingSet& set, const ContactList& contacts,
                   const CycleLimit& limit, DetectionResult& result);

}  // namespace deformable_contact_monitor
