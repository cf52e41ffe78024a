// Reads a tree of ROS parameters and collects every problem, so that a user sees all at once.
//
// Every function first notes the name as known, which unknown() needs, then checks the type, then
// the range. A value that cannot be used becomes its fallback, so that reading can go on.
#include "monitor/rules/parameter_reader.h"

#include <limits>
#include <locale>
#include <regex>
#include <sstream>

#include "robot/nearest_name.h"

namespace deformable_contact_monitor {
namespace {

using XmlRpc::XmlRpcValue;

// Returns the value as text for an error message.
std::string shown(const XmlRpcValue& value) {
  std::ostringstream text;
  value.write(text);
  return text.str();
}

// Returns the range as text for an error message.
template <typename T>
std::string range(T low, T high) {
  std::ostringstream text;
  text << "must be in [" << low << ", " << high << "]";
  return text.str();
}

// Returns whether the text is a decimal number with an exponent.
bool isExponential(const std::string& text) {
  static const std::regex kNumber(R"([-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+)");
  constexpr std::size_t kLongest = 64;  // std::regex recurses
  return text.size() <= kLongest && std::regex_match(text, kNumber);
}

// Reads a number of that form in every locale.
double toDouble(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  double number = 0;
  in >> number;  // beyond the range of double, it is the largest number
  return number;
}

}  // namespace

bool replaceTextsByNumbers(XmlRpcValue* map) {
  bool is_changed = false;
  for (auto& [key, value] : *map) {
    is_changed |= value.getType() == XmlRpcValue::TypeStruct ? replaceTextsByNumbers(&value)
                                                             : replaceTextByNumber(&value);
  }
  return is_changed;
}

bool replaceTextByNumber(XmlRpcValue* value) {
  if (value->getType() != XmlRpcValue::TypeString) return false;
  const std::string text = static_cast<const std::string&>(*value);
  if (!isExponential(text)) return false;
  *value = toDouble(text);
  return true;
}

ParameterReader::ParameterReader(const XmlRpcValue& tree, std::string where,
                                 std::vector<std::string>* problems)
    : tree_(tree), where_(std::move(where)), problems_(problems) {
  if (tree_.valid() && tree_.getType() != XmlRpcValue::TypeStruct) {
    problems_->push_back(where_ + " must be a map of names to values");
    tree_ = XmlRpcValue();
  }
}

void ParameterReader::addProblem(const std::string& name, const std::string& what) {
  problems_->push_back(where_ + name + " " + what);
}

// XmlRpcValue writes lists in braces and maps in brackets; yaml has them the other way round.
void ParameterReader::addChanged(const std::string& name, const XmlRpcValue& value) {
  constexpr std::size_t kMostCharacters = 100;
  const bool is_list = value.getType() == XmlRpcValue::TypeArray;
  if ((is_list || value.getType() == XmlRpcValue::TypeStruct) && value.size() == 0) return;
  std::string text = shown(value);
  for (char& c : text) {
    const std::string from = "[]{}", to = "{}[]";
    const std::size_t at = from.find(c);
    if (at != std::string::npos) c = to[at];
  }
  if (text.size() > kMostCharacters) text = text.substr(0, kMostCharacters) + "...";
  changed_.push_back(name + ": " + text);
}

// XmlRpcValue's operator[] would add a missing member, hence the check before.
const XmlRpcValue* ParameterReader::find(const std::string& name) {
  known_.insert(name);
  if (!tree_.valid() || !tree_.hasMember(name)) return nullptr;
  return &tree_[name];
}

const XmlRpcValue* ParameterReader::find(const std::string& name, XmlRpcValue::Type type,
                                         const std::string& wanted) {
  const XmlRpcValue* value = find(name);
  if (value == nullptr || value->getType() == type) return value;
  addProblem(name, "is " + shown(*value) + ", must be " + wanted);
  return nullptr;
}

// Accepts no numbers and texts such as "yes": what they mean would be a guess.
bool ParameterReader::flag(const std::string& name, bool fallback) {
  const XmlRpcValue* value = find(name, XmlRpcValue::TypeBoolean, "true or false");
  if (value == nullptr) return fallback;
  const bool flag = static_cast<const bool&>(*value);
  if (flag != fallback) addChanged(name, XmlRpcValue(flag ? "true" : "false"));
  return flag;
}

// The two functions below check one value, which may be an element of a list or map. They return
// false, and add a problem under `name`, if the value cannot be used.
bool ParameterReader::toInteger(const std::string& name, const XmlRpcValue& value, int low,
                                int high, int* integer) {
  if (value.getType() != XmlRpcValue::TypeInt) {
    addProblem(name, "is " + shown(value) + ", must be a whole number");
    return false;
  }
  *integer = static_cast<const int&>(value);
  if (*integer >= low && *integer <= high) return true;
  addProblem(name, "is " + shown(value) + ", " + range(low, high));
  return false;
}

int ParameterReader::integer(const std::string& name, int fallback, int low, int high) {
  const XmlRpcValue* value = find(name);
  int integer = fallback;
  if (value == nullptr || !toInteger(name, *value, low, high, &integer)) return fallback;
  if (integer != fallback) addChanged(name, *value);
  return integer;
}

// Bad elements are problems of their own ("devices[1]"); the good ones are still returned.
std::vector<int> ParameterReader::integers(const std::string& name, int low, int high) {
  const XmlRpcValue* value = find(name, XmlRpcValue::TypeArray, "a list of whole numbers: [0, 1]");
  if (value == nullptr) return {};
  addChanged(name, *value);
  std::vector<int> integers;
  for (int i = 0; i < value->size(); ++i) {
    const std::string item = name + "[" + std::to_string(i) + "]";
    int integer = 0;
    if (toInteger(item, (*value)[i], low, high, &integer)) integers.push_back(integer);
  }
  return integers;
}

bool ParameterReader::toNumber(const std::string& name, const XmlRpcValue& value, double low,
                               double high, double* number) {
  // A whole number such as 1 arrives as an integer, although the parameter is a double.
  if (value.getType() == XmlRpcValue::TypeInt) {
    *number = static_cast<const int&>(value);
  } else if (value.getType() == XmlRpcValue::TypeDouble) {
    *number = static_cast<const double&>(value);
  } else if (value.getType() == XmlRpcValue::TypeString &&
             isExponential(static_cast<const std::string&>(value))) {
    *number = toDouble(static_cast<const std::string&>(value));
  } else {
    addProblem(name, "is " + shown(value) + ", must be a number");
    return false;
  }
  // This comparison is false for NaN, too.
  if (*number >= low && *number <= high) return true;
  std::ostringstream text;
  text << "is " << *number << ", " << range(low, high);
  addProblem(name, text.str());
  return false;
}

double ParameterReader::number(const std::string& name, double fallback, double low, double high) {
  const XmlRpcValue* value = find(name);
  double number = fallback;
  if (value == nullptr || !toNumber(name, *value, low, high, &number)) return fallback;
  // Defaults that are stored as float32 are those of the configuration file, rounded.
  if (static_cast<float>(number) != static_cast<float>(fallback)) addChanged(name, *value);
  return number;
}

// An empty text mostly means that a launch argument was forgotten.
std::string ParameterReader::text(const std::string& name, const std::string& fallback) {
  const XmlRpcValue* const value = find(name);
  std::string text = optionalText(name, fallback);
  const bool is_text = value != nullptr && value->getType() == XmlRpcValue::TypeString;
  if (!is_text || !text.empty()) return text;
  addProblem(name, "is empty");
  return fallback;
}

std::string ParameterReader::optionalText(const std::string& name, const std::string& fallback) {
  const XmlRpcValue* const value = find(name, XmlRpcValue::TypeString, "text");
  if (value == nullptr) return fallback;
  const auto& text = static_cast<const std::string&>(*value);
  if (text != fallback) addChanged(name, *value);
  return text;
}

// Lists all choices in the error message.
std::size_t ParameterReader::choice(const std::string& name,
                                    const std::vector<std::string>& choices, std::size_t fallback) {
  const std::string value = text(name, choices[fallback]);
  std::string all;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (value == choices[i]) return i;
    all += (i == 0 ? "" : ", ") + choices[i];
  }
  addProblem(name, "is '" + value + "', must be one of: " + all);
  return fallback;
}

std::vector<std::string> ParameterReader::texts(const std::string& name,
                                                const std::vector<std::string>& fallback) {
  const XmlRpcValue* value = find(name, XmlRpcValue::TypeArray, "a list of texts: [a, b]");
  if (value == nullptr) return fallback;
  std::vector<std::string> texts;
  for (int i = 0; i < value->size(); ++i) {
    const XmlRpcValue& item = (*value)[i];
    if (item.getType() == XmlRpcValue::TypeString) {
      texts.push_back(static_cast<const std::string&>(item));
    } else {
      addProblem(name + "[" + std::to_string(i) + "]", "is " + shown(item) + ", must be text");
    }
  }
  if (texts != fallback) addChanged(name, *value);
  return texts;
}

// Reports problems of elements by "<name>/<key>", as a path of the parameter server.
std::map<std::string, double> ParameterReader::numbers(const std::string& name, double low,
                                                       double high) {
  const XmlRpcValue* value =
      find(name, XmlRpcValue::TypeStruct, "a map of names to numbers: {a: 0.1}");
  if (value == nullptr) return {};
  addChanged(name, *value);
  std::map<std::string, double> numbers;
  addNumbers(name, "", *value, low, high, &numbers);
  return numbers;
}

void ParameterReader::addNumbers(const std::string& name, const std::string& prefix,
                                 const XmlRpcValue& map, double low, double high,
                                 std::map<std::string, double>* numbers) {
  for (const auto& [key, item] : map) {
    double number = 0;
    std::string whole = prefix;
    whole += key;
    if (item.getType() == XmlRpcValue::TypeStruct) {
      whole += '/';
      addNumbers(name, whole, item, low, high, numbers);
      continue;
    }
    std::string parameter = name;
    parameter += '/';
    parameter += whole;
    if (toNumber(parameter, item, low, high, &number)) (*numbers)[whole] = number;
  }
}

std::vector<std::pair<int, int>> ParameterReader::ranges(const std::string& name, int low,
                                                         int high) {
  const XmlRpcValue* value =
      find(name, XmlRpcValue::TypeArray, "a list of ranges: [[0, 99], [200, 250]]");
  if (value == nullptr) return {};
  std::vector<std::pair<int, int>> ranges;
  for (int i = 0; i < value->size(); ++i) {
    const XmlRpcValue& item = (*value)[i];
    const std::string item_name = name + "[" + std::to_string(i) + "]";
    int first = 0, last = 0;
    if (item.getType() != XmlRpcValue::TypeArray || item.size() != 2) {
      addProblem(item_name, "is " + shown(item) + ", must be a range: [0, 99]");
    } else if (toInteger(item_name, item[0], low, high, &first) &&
               toInteger(item_name, item[1], first, high, &last)) {
      ranges.emplace_back(first, last);
    }
  }
  return ranges;
}

std::optional<std::array<double, 3>> ParameterReader::point(const std::string& name) {
  const XmlRpcValue* value = find(name);
  if (value == nullptr || value->getType() != XmlRpcValue::TypeArray || value->size() != 3) {
    addProblem(name, "must be three numbers: [0.1, 0, 0]");
    return std::nullopt;
  }
  constexpr double kMost = std::numeric_limits<float>::max();
  std::array<double, 3> point{};
  for (int i = 0; i < 3; ++i) {
    const std::string item = name + "[" + std::to_string(i) + "]";
    if (!toNumber(item, (*value)[i], -kMost, kMost, &point[static_cast<std::size_t>(i)])) {
      return std::nullopt;
    }
  }
  return point;
}

std::optional<ParameterReader> ParameterReader::section(const std::string& name) {
  const XmlRpcValue* value = find(name);
  if (value == nullptr) return std::nullopt;
  return ParameterReader(*value, where_ + name + "/", problems_);
}

// Each reader checks itself that its element is a map.
std::vector<ParameterReader> ParameterReader::structs(const std::string& name) {
  const XmlRpcValue* value =
      find(name, XmlRpcValue::TypeArray, "a list of maps: [{name: a}, {name: b}]");
  if (value == nullptr) return {};
  addChanged(name, *value);
  std::vector<ParameterReader> readers;
  readers.reserve(static_cast<std::size_t>(value->size()));
  for (int i = 0; i < value->size(); ++i) {
    readers.emplace_back((*value)[i], where_ + name + "[" + std::to_string(i) + "]/", problems_);
  }
  return readers;
}

// Compares with the names that were asked for, so call it after all others.
std::vector<std::string> ParameterReader::unknown() const {
  std::vector<std::string> names;
  if (!tree_.valid()) return names;
  const std::vector<std::string> known(known_.begin(), known_.end());
  for (const auto& entry : tree_) {
    if (known_.count(entry.first) != 0) continue;
    names.push_back(where_ + entry.first + nearestNameHint(entry.first, known));
  }
  return names;
}

void ParameterReader::warnOfUnknown(std::vector<std::string>* warnings) const {
  for (const std::string& name : unknown()) {
    warnings->push_back(name + " is not a parameter of this node and is ignored");
  }
}

// tf2 knows no names that begin with '/', unlike the first tf.
void ParameterReader::refuseSlash(const std::string& name, const std::string& frame) {
  if (frame.substr(0, 1) == "/") addProblem(name, "is '" + frame + "', must not begin with '/'");
}

}  // namespace deformable_contact_monitor
