// Patches of contacts as a message.
#pragma once

#include <deformable_contact_monitor/ContactPatches.h>

#include <vector>

#include "core/analysis/contact_patches.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// `patches`: of the report's scene, in their order.
ContactPatches toContactPatches(const CycleReport& report, const std::vector<Patch>& patches);

}  // namespace deformable_contact_monitor
