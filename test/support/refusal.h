// Returns error messages as text, for tests that compare them.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

namespace deformable_contact_monitor {

// The message of the std::invalid_argument that `action` throws; empty if it throws nothing.
inline std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace deformable_contact_monitor
