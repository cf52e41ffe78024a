// Names that were mistyped: which one may have been meant.
#pragma once

#include <string>
#include <vector>

namespace deformable_contact_monitor {

// " (did you mean 'hand'?)" with the name that the fewest edits (a letter added, left out or
// replaced) lead to; empty if all are too different, or the name is longer than 100 bytes.
std::string nearestNameHint(const std::string& name, const std::vector<std::string>& known);

}  // namespace deformable_contact_monitor
