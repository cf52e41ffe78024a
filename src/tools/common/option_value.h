// Values of options: from text and back, alike in every locale, and what is allowed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/options.h"

namespace deformable_contact_monitor {

// A Value is std::string, int, unsigned, std::uint64_t, float, double or AdjacentPairs.

// How --help calls a Value.
template <class Value>
const char* kindOf();

// False if `text` as a whole is no Value; NaN and infinity are none.
template <class Value>
bool fromText(const std::string& text, Value* value);

template <class Value>
std::string toText(const Value& value);

std::vector<std::string> splitAtCommas(const std::string& text);

template <class Value>
std::string joined(const std::vector<Value>& values, const char* between) {
  std::string text;
  for (const Value& value : values) text += (text.empty() ? "" : between) + toText(value);
  return text;
}

// Help of --adjacent.
constexpr const char* kAdjacentHelp =
    "Triangles of one body that share a vertex: skip them, or report those that meet beyond what "
    "they share";

// Which values an option takes; as it stands here, all.
template <class Value>
struct Allowed {
  std::string text;  // "in [1, 9]", to follow "is" and "is not"
  std::function<bool(const Value&)> holds = [](const Value& /*any*/) { return true; };
};

template <class Value>
Allowed<Value> inRange(Value least, Value most) {
  return {"in [" + toText(least) + ", " + toText(most) + "]",
          [=](const Value& value) { return value >= least && value <= most; }};
}

Allowed<double> isPositive();
Allowed<std::string> oneOf(const std::vector<std::string>& values);

}  // namespace deformable_contact_monitor
