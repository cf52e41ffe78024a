// The main function that all tools share: errors become one line and an exit code.
//
// Exit code 2 always means that one line on standard error says what is wrong.
#pragma once

#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>

namespace deformable_contact_monitor {

// Replaces control characters by '?', for messages. Names in foreign files may contain them.
inline std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, '?');
  return text;
}

// Runs `body` and returns its exit code. If it throws a std::exception, writes one line to standard
// error, "<name>: <what>", and returns 2.
inline int runTool(const std::string& name, const std::function<int()>& body) {
  try {
    return body();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), oneLine(error.what()).c_str());
    return 2;
  }
}

}  // namespace deformable_contact_monitor
