// Returns error messages as text, and finds texts in them.
#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace deformable_contact_monitor {

// Returns the message of the Error that `action` throws; empty if it throws nothing.
template <class Error = std::invalid_argument, class Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

inline void expectIn(const std::string& text, const std::string& all) {
  EXPECT_NE(all.find(text), std::string::npos) << "'" << text << "' is not in:\n" << all;
}

}  // namespace deformable_contact_monitor
