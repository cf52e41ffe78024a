// Vertex numbers in the text of a mesh file.
#pragma once

#include <algorithm>
#include <string>

namespace deformable_contact_monitor {

// Whether it is a number from 0 to 2^31 - 1, which no reader's integer is too small for.
inline bool isIndex(const std::string& text) {
  const std::string digits = text.substr(std::min(text.find_first_not_of('0'), text.size()));
  const bool is_digits = text.find_first_not_of("0123456789") == std::string::npos;
  const std::string largest = "2147483647";
  return !text.empty() && is_digits &&
         (digits.size() < largest.size() || (digits.size() == largest.size() && digits <= largest));
}

// For messages, since it may be as long as the file.
inline std::string shortened(const std::string& text) {
  constexpr std::size_t kShown = 40;
  return text.size() <= kShown ? text : text.substr(0, kShown) + "...";
}

}  // namespace deformable_contact_monitor
