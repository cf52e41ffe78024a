// Contacts of different pairs of bodies as one result.
#pragma once

#include <vector>

#include "core/bounds/pair_list.h"
#include "core/detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Adds contacts, sorted, to those of `result`: pairs of bodies that it has none of. Their geometry,
// if it is asked for, is made here. The scene's vertices are on the host, of bodies that they are
// of.
void mergeContacts(const Scene& scene, const Options& options,
                   const std::vector<ListedContact>& contacts, DetectionResult& result);

}  // namespace deformable_contact_monitor
