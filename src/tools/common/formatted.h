// Text with numbers in it.
#pragma once

#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>

namespace deformable_contact_monitor {

// Returns what std::printf() would print.
[[gnu::format(printf, 1, 2)]] inline std::string formatted(const char* format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  char* text = nullptr;
  const int length = vasprintf(&text, format, arguments);
  va_end(arguments);
  if (length < 0) throw std::bad_alloc();
  const std::unique_ptr<char, void (*)(void*)> owned(text, std::free);
  return text;
}

// Replaces numbers by '#', because stamps and counts differ from cycle to cycle. Digits within a
// word, as in "link_2", are part of a name and stay.
inline std::string withoutNumbers(const std::string& text) {
  const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
  std::string kept;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    if (i == 0 || text[i - 1] == ' ') {
      while (end < text.size() && (isDigit(text[end]) || text[end] == '.')) ++end;
    }
    // A number ends at a blank, at a comma or at the end of the text.
    const bool is_number = end > i && (end == text.size() || text[end] == ' ' || text[end] == ',');
    kept += is_number ? '#' : text[i];
    i = is_number ? end : i + 1;
  }
  return kept;
}

}  // namespace deformable_contact_monitor
