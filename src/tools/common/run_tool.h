// How every tool of ours ends.
#pragma once

#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>

namespace deformable_contact_monitor {

// For messages: control characters, which names in foreign files may have, as '?'.
inline std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, '?');
  return text;
}

// Runs `body` and returns its exit code. A std::exception from it becomes one line on standard
// error, "<name>: <what>", and exit code 2.
inline int runTool(const std::string& name, const std::function<int()>& body) {
  try {
    return body();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), oneLine(error.what()).c_str());
    return 2;
  }
}

}  // namespace deformable_contact_monitor
