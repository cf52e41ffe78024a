// What an evaluation is of, and what decides which contacts there are.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_setup.h"

namespace deformable_contact_monitor {

// The bags' topics: types and numbers of messages.
nlohmann::json topicsJson(const BagContents& contents);

// What decides which contacts there are.
nlohmann::json configurationJson(const BagSetup& setup);

}  // namespace deformable_contact_monitor
