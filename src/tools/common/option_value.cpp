// Values of options: from text and back, alike in every locale, and what is allowed.
#include "tools/common/option_value.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <locale>
#include <sstream>
#include <system_error>
#include <type_traits>

namespace deformable_contact_monitor {

template <class Value>
const char* kindOf() {
  if (std::is_same_v<Value, AdjacentPairs>) return "skip|beyond_shared";
  if (std::is_integral_v<Value>) return "INT";
  return std::is_floating_point_v<Value> ? "FLOAT" : "TEXT";
}

template <class Value>
bool fromText(const std::string& text, Value* value) {
  if constexpr (std::is_same_v<Value, std::string>) {
    *value = text;
    return true;
  } else if constexpr (std::is_same_v<Value, AdjacentPairs>) {
    *value = text == "skip" ? AdjacentPairs::kSkip : AdjacentPairs::kBeyondShared;
    return text == toString(*value);
  } else if constexpr (std::is_integral_v<Value>) {
    const char* const end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, *value);
    return parsed.ec == std::errc() && parsed.ptr == end;
  } else {
    std::istringstream in(text);
    in.imbue(std::locale::classic());
    in >> std::noskipws >> *value;
    return !in.fail() && in.peek() == std::istringstream::traits_type::eof();
  }
}

template <class Value>
std::string toText(const Value& value) {
  if constexpr (std::is_same_v<Value, AdjacentPairs>) {
    return toString(value);
  } else {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out << value;
    return out.str();
  }
}

std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t comma = 0; comma != std::string::npos; begin = comma + 1) {
    comma = text.find(',', begin);
    parts.push_back(text.substr(begin, comma - begin));
  }
  return parts;
}

Allowed<double> isPositive() {
  return {"> 0", [](double value) { return value > 0; }};
}

Allowed<std::string> oneOf(const std::vector<std::string>& values) {
  return {"one of " + joined(values, ", "), [values](const std::string& value) {
            return std::find(values.begin(), values.end(), value) != values.end();
          }};
}

#define DCM_OPTION_VALUE(Value)                                  \
  template const char* kindOf<Value>();                          \
  template bool fromText(const std::string& text, Value* value); \
  template std::string toText(const Value& value)
DCM_OPTION_VALUE(std::string);
DCM_OPTION_VALUE(int);
DCM_OPTION_VALUE(unsigned);
DCM_OPTION_VALUE(std::uint64_t);
DCM_OPTION_VALUE(float);
DCM_OPTION_VALUE(double);
DCM_OPTION_VALUE(AdjacentPairs);

}  // namespace deformable_contact_monitor
