// Text in tables of comma-separated values.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// Quoted where it has to be (RFC 4180).
inline std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace deformable_contact_monitor
