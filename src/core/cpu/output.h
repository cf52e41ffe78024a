// Stage `output`: contacts of the working set as the result's sorted list.
#pragma once

#include "core/cpu/contact_list.h"
#include "core/cpu/pose.h"
#include "core/cycle_limit.h"
#include "core/detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Fills result.contacts, result.left_out and what there is beside each contact: separations_m if
// scene.anyMargin(), or, of what moves, first_times and within_pad as the options and the scene
// ask; all were empty. Once the limit is over, no more contacts than are sorted in little time:
// then others are left out, and the result says that it was cut off. Hull: as in hull.h.
template <class Hull>
void writeContacts(const Scene& scene, const Options& options, const WorkingSet& set,
                   const ContactList<Hull>& contacts, const CycleLimit& limit,
                   DetectionResult& result);

}  // namespace deformable_contact_monitor
