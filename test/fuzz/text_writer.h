// Words for texts that are mostly well-formed, made of an input's bytes.
#pragma once

#include <cstddef>
#include <iterator>
#include <string>

#include "byte_source.h"

namespace deformable_contact_monitor {

// A decimal number; seldom one that is hard to read, or none.
inline std::string numberText(ByteSource* source) {
  constexpr const char* kHard[] = {"nan", "-inf", "1e39",  "1e-50", "3.4028236e38", "0x1p3",
                                   "1e",  "--1",  "1e999", "+2",    "1,5",          "%n"};
  constexpr std::uint8_t kFirstHard = 256 - std::size(kHard), kFirstPlain = 128;
  const std::uint8_t code = source->byte();
  if (code >= kFirstHard) return kHard[code - kFirstHard];
  if (code >= kFirstPlain) return std::to_string(source->number<std::int16_t>()) + "e-3";
  constexpr int kMiddle = 64;
  return std::to_string(code - kMiddle);
}

inline std::string numberTexts(ByteSource* source, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : " ") + numberText(source);
  return text;
}

// In [0, count), seldom one that is not.
inline long indexFrom(ByteSource* source, std::size_t count) {
  constexpr long kWrong[] = {-1, 2147483647, 4294967295, 4294967296};
  constexpr std::uint8_t kFirstWrong = 256 - std::size(kWrong);
  const std::uint8_t code = source->byte();
  if (code >= kFirstWrong) return kWrong[code - kFirstWrong];
  return count == 0 ? 0 : static_cast<long>(code % count);
}

// `right`, seldom another number.
inline std::string countText(ByteSource* source, std::size_t right) {
  constexpr std::uint8_t kFirstWrong = 252;
  const std::uint8_t code = source->byte();
  if (code < kFirstWrong) return std::to_string(right);
  constexpr const char* kWrong[] = {"0", "-1", "4000000000", "99999999999999999999"};
  return kWrong[code - kFirstWrong];
}

}  // namespace deformable_contact_monitor
