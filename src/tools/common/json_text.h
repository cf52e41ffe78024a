// JSON as the tools write it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace deformable_contact_monitor {

// Indented, keys in alphabetical order, with a line end. A file name, or a name in a bag, need not
// be UTF-8, but JSON must: what is not becomes U+FFFD.
inline std::string jsonText(const nlohmann::json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace deformable_contact_monitor
