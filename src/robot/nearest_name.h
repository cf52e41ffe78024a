// Suggests a known name for one that was mistyped.
#pragma once

#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Returns " (did you mean 'hand'?)" with the known name that needs the fewest edits (a letter
// added, left out or replaced); empty if all are too different, or the name is longer than 100
// bytes.
std::string nearestNameHint(const std::string& name, const std::vector<std::string>& known);

}  // namespace deformable_contact_monitor
