// Reads command lines with Boost.Program_options, which only splits them into options and words.
// All values are converted here, so that errors name the option and its range.
#include "tools/common/command_line.h"

#include <algorithm>
#include <boost/algorithm/string/split.hpp>
#include <charconv>
#include <cstdint>
#include <iostream>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <type_traits>

namespace deformable_contact_monitor {
namespace {

namespace po = boost::program_options;

// An option's words. Boost's own values take one word, or any number of them.
class WordsValue : public po::typed_value<std::vector<std::string>> {
 public:
  WordsValue(unsigned least, unsigned most) : typed_value(nullptr), least_(least), most_(most) {}
  unsigned min_tokens() const override { return least_; }
  unsigned max_tokens() const override { return most_; }

 private:
  unsigned least_, most_;
};

}  // namespace

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
    // The decimal point must not depend on the user's locale.
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

// Two commas in a row give an empty part, which the caller rejects.
std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  boost::split(parts, text, [](char c) { return c == ','; });
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

// NOLINTBEGIN(bugprone-macro-parentheses): the argument is a type
#define DCM_OPTION_VALUE(Value)                                  \
  template const char* kindOf<Value>();                          \
  template bool fromText(const std::string& text, Value* value); \
  template std::string toText(const Value& value)
// NOLINTEND(bugprone-macro-parentheses)
DCM_OPTION_VALUE(std::string);
DCM_OPTION_VALUE(int);
DCM_OPTION_VALUE(unsigned);
DCM_OPTION_VALUE(std::uint64_t);
DCM_OPTION_VALUE(float);
DCM_OPTION_VALUE(double);
DCM_OPTION_VALUE(AdjacentPairs);

void refuseUsage(const std::string& what) { throw std::invalid_argument(what + " (see --help)"); }

CommandLine::CommandLine(const std::string& program, const std::string& description,
                         const std::string& footer)
    : program_(program), description_(description), footer_(footer), options_("Options") {
  options_.add_options()("help,h", "Print this and exit")("version", "Print the version and exit");
}

void CommandLine::addOption(const Shape& shape, const std::string& help, const std::string& value,
                            const Reader& reader) {
  auto* words = new WordsValue(shape.least_words, shape.most_words);  // Boost takes the ownership
  words->value_name(shape.kind);
  // An empty default is not shown.
  const std::string whole = value.empty() ? help : help + " (default: " + value + ")";
  options_.add_options()(shape.name.substr(2).c_str(), words, whole.c_str());
  readers_[shape.name] = reader;
}

void CommandLine::addFlag(const std::string& name, bool* value, const std::string& help) {
  addOption({name, "", 0, 0}, help, "", [value](const Words& /*none*/) { *value = true; });
}

// Takes exactly as many words as there are defaults.
void CommandLine::addNumbers(const std::string& name, std::vector<double>* numbers,
                             const std::string& help) {
  const auto count = static_cast<unsigned>(numbers->size());
  addOption({name, "FLOAT...", count, count}, help, joined(*numbers, " "),
            [name, numbers](const Words& words) {
              for (std::size_t i = 0; i < words.size(); ++i) {
                (*numbers)[i] = read(name, words[i], Allowed<double>());
              }
            });
}

// Takes at least one word. An option that comes again adds its words to the earlier ones.
void CommandLine::addWords(const std::string& name, std::vector<std::string>* words,
                           const std::string& help) {
  addOption({name, "TEXT...", 1, std::numeric_limits<int>::max()}, help, "",
            [words](const Words& given) { *words = given; });
  repeatable_.insert(name);
}

// Collects the values of all words.
void CommandLine::addRepeated(const std::string& name, std::vector<std::string>* values,
                              const std::string& help) {
  addOption({name, "TEXT,...", 1, 1}, help, joined(*values, ","),
            [name, values](const Words& words) {
              values->clear();
              for (const std::string& word : words) {
                for (const std::string& value : splitAtCommas(word)) {
                  if (value.empty()) refuseUsage(name + ": has an empty value");
                  values->push_back(value);
                }
              }
            });
  repeatable_.insert(name);
}

void CommandLine::addPositionals(const std::string& name, std::vector<std::string>* words,
                                 bool required, const std::string& help) {
  positionals_ = name;
  positionals_help_ = help;
  positionals_required_ = required;
  readers_[name] = [words](const Words& given) { *words = given; };
  repeatable_.insert(name);
}

void CommandLine::refuseTogether(const std::string& one, const std::string& other) {
  not_together_.emplace_back(one, other);
}

void CommandLine::requireFor(const std::string& option, const std::string& required) {
  required_for_.emplace_back(option, required);
}

bool CommandLine::parse(int argc, const char* const* argv) {
  return parse(std::vector<std::string>(argv + std::min(argc, 1), argv + argc));
}

// Abbreviated options are not accepted: a new option would change their meaning.
bool CommandLine::parse(const std::vector<std::string>& words) {
  namespace style = po::command_line_style;
  try {
    const po::parsed_options parsed = po::command_line_parser(words)
                                          .options(options_)
                                          .style(style::unix_style & ~style::allow_guessing)
                                          .run();
    if (printAnswer(parsed)) return false;
    readAll(parsed);
  } catch (const po::error& error) {
    refuseUsage(error.what());
  }
  return true;
}

// Answers --help and --version. Returns false if neither is there.
bool CommandLine::printAnswer(const po::parsed_options& parsed) const {
  for (const po::option& option : parsed.options) {
    if (option.string_key == "help") printHelp();
    if (option.string_key == "version") std::cout << program_ << " " << DCM_VERSION << "\n";
    if (option.string_key == "help" || option.string_key == "version") return true;
  }
  return false;
}

// Collects the words of each option first, because repeatable options may come several times.
void CommandLine::readAll(const po::parsed_options& parsed) const {
  std::map<std::string, Words> words;
  std::set<std::string> given;
  for (const po::option& option : parsed.options) {
    // Boost gives positionals an empty name.
    const bool is_positional = option.string_key.empty();
    if (is_positional && positionals_.empty()) {
      refuseUsage("'" + option.value.front() + "' belongs to no option");
    }
    const std::string name = is_positional ? positionals_ : "--" + option.string_key;
    if (!given.insert(name).second && repeatable_.count(name) == 0) {
      refuseUsage(name + ": is given twice");
    }
    Words& all = words[name];
    all.insert(all.end(), option.value.begin(), option.value.end());
  }
  checkRules(given);
  for (const auto& [name, all] : words) readers_.at(name)(all);
}

// Rules are checked before any value is read.
void CommandLine::checkRules(const std::set<std::string>& given) const {
  const auto is_given = [&given](const std::string& name) { return given.count(name) != 0; };
  const auto refuse = [](const std::string& one, const char* between, const std::string& other,
                         const char* end) { refuseUsage(one + between + other + end); };
  if (positionals_required_ && !is_given(positionals_)) refuseUsage(positionals_ + " is required");
  for (const auto& [one, other] : not_together_) {
    if (is_given(one) && is_given(other)) refuse(one, " and ", other, ": not together");
  }
  for (const auto& [option, required] : required_for_) {
    if (is_given(option) && !is_given(required)) refuse(option, ": needs ", required, "");
  }
}

void CommandLine::printHelp() const {
  std::cout << description_ << "\n\nUsage: " << program_ << " [OPTION...]";
  if (!positionals_.empty()) {
    std::cout << (positionals_required_ ? " " : " [") << positionals_
              << (positionals_required_ ? "..." : "...]") << "\n\n"
              << positionals_ << ": " << positionals_help_;
  }
  std::cout << "\n\n" << options_;
  if (!footer_.empty()) std::cout << "\n" << footer_ << "\n";
}

}  // namespace deformable_contact_monitor
