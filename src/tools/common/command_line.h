// The command line of every tool: options, their values, --help and --version.
//
// Boost.Program_options splits the words; this class adds types, allowed ranges, lists, rules
// between options, and one-line errors that name the option.
#pragma once

#include <boost/program_options.hpp>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/options.h"

namespace deformable_contact_monitor {

// A Value of an option is std::string, int, unsigned, std::uint64_t, float, double or
// AdjacentPairs. Texts are read and written alike in every locale.

// Returns the name of the Value's type in --help.
template <class Value>
const char* kindOf();

// Reads the whole text as a Value. Returns false if it is not one. NaN and infinity are not
// accepted.
template <class Value>
bool fromText(const std::string& text, Value* value);

// Writes a Value as fromText() reads it.
template <class Value>
std::string toText(const Value& value);

// Returns the parts of the text between commas; at least one.
std::vector<std::string> splitAtCommas(const std::string& text);

// Returns the values, which are in any container, as one text.
template <class Values>
std::string joined(const Values& values, const char* between) {
  std::string text;
  for (const auto& value : values) text += (text.empty() ? "" : between) + toText(value);
  return text;
}

// The help text of --adjacent, which several tools have.
constexpr const char* kAdjacentHelp =
    "Triangles of one body that share a vertex: skip them, or report those that meet beyond what "
    "they share";

// The values that an option takes. A default-constructed Allowed takes all.
template <class Value>
struct Allowed {
  std::string text;  // for example "in [1, 9]"; it follows "is" and "is not" in messages
  std::function<bool(const Value&)> holds = [](const Value& /*any*/) { return true; };
};

// Allows values from `least` to `most`.
template <class Value>
Allowed<Value> inRange(Value least, Value most) {
  return {"in [" + toText(least) + ", " + toText(most) + "]",
          [=](const Value& value) { return value >= least && value <= most; }};
}

// Allows numbers above 0, or one of the listed texts.
Allowed<double> isPositive();
Allowed<std::string> oneOf(const std::vector<std::string>& values);

// Reports bad usage: throws std::invalid_argument, one line that points to --help.
[[noreturn]] void refuseUsage(const std::string& what);

// Reads options (`--name VALUE` or `--name=VALUE`) and positionals, the words that belong to no
// option. Each is read into a variable that must outlive parse(). The value that the variable has
// before is the default, which --help shows. Names include their dashes. --help and --version
// always exist.
class CommandLine {
 public:
  CommandLine(const std::string& program, const std::string& description,
              const std::string& footer = "");

  // Adds an option without a value, which sets the variable to true.
  void addFlag(const std::string& name, bool* value, const std::string& help);

  // Adds an option with one value.
  template <class Value>
  void add(const std::string& name, Value* value, const std::string& help,
           const Allowed<Value>& allowed = {}) {
    addOption({name, kindOf<Value>(), 1, 1}, withAllowed(help, allowed.text), toText(*value),
              [=](const Words& words) { *value = read(name, words.front(), allowed); });
  }

  // Adds an option with one value and without a default.
  template <class Value>
  void add(const std::string& name, std::optional<Value>* value, const std::string& help,
           const Allowed<Value>& allowed = {}) {
    addOption({name, kindOf<Value>(), 1, 1}, withAllowed(help, allowed.text), "",
              [=](const Words& words) { *value = read(name, words.front(), allowed); });
  }

  // Adds an option with a list of values, separated by commas.
  template <class Value>
  void addList(const std::string& name, std::vector<Value>* values, const std::string& help,
               const Allowed<Value>& allowed = {}) {
    addOption({name, std::string(kindOf<Value>()) + ",...", 1, 1}, withAllowed(help, allowed.text),
              joined(*values, ","), [=](const Words& words) {
                values->clear();
                for (const std::string& text : splitAtCommas(words.front())) {
                  if (text.empty()) refuseUsage(name + ": has an empty value");
                  values->push_back(read(name, text, allowed));
                }
              });
  }

  // Adds an option that takes as many words as `numbers` has elements.
  void addNumbers(const std::string& name, std::vector<double>* numbers, const std::string& help);

  // Adds an option that may be given several times, and each time has one or more values, separated
  // by commas.
  void addRepeated(const std::string& name, std::vector<std::string>* values,
                   const std::string& help);

  // Adds an option that takes all words up to the next option. It may be given several times.
  void addWords(const std::string& name, std::vector<std::string>* words, const std::string& help);

  // Allows positionals; without this call they are an error.
  void addPositionals(const std::string& name, std::vector<std::string>* words, bool required,
                      const std::string& help);

  // Makes it an error to give both options, or to give an option without the one that it requires.
  void refuseTogether(const std::string& one, const std::string& other);
  void requireFor(const std::string& option, const std::string& required);

  // Reads the command line. Returns false if --help or --version was asked for and is printed.
  // Throws as refuseUsage() does, and names the option.
  bool parse(int argc, const char* const* argv);
  // Does the same with the words that follow the program's name.
  bool parse(const std::vector<std::string>& words);

 private:
  using Words = std::vector<std::string>;
  using Reader = std::function<void(const Words&)>;
  // An option's name, the type in --help, and how many words it takes.
  struct Shape {
    std::string name, kind;
    unsigned least_words, most_words;
  };

  template <class Value>
  static Value read(const std::string& name, const std::string& text,
                    const Allowed<Value>& allowed) {
    Value value{};
    if (!fromText(text, &value)) {
      refuseUsage(name + ": '" + text + "' cannot be read as " + kindOf<Value>());
    }
    if (!allowed.holds(value)) refuseUsage(name + ": " + text + " is not " + allowed.text);
    return value;
  }

  static std::string withAllowed(const std::string& help, const std::string& allowed) {
    return allowed.empty() ? help : help + "; " + allowed;
  }

  void addOption(const Shape& shape, const std::string& help, const std::string& value,
                 const Reader& reader);
  // Parts of parse(). command_line.cpp says what each does.
  bool printAnswer(const boost::program_options::parsed_options& parsed) const;
  void readAll(const boost::program_options::parsed_options& parsed) const;
  void checkRules(const std::set<std::string>& given) const;
  void printHelp() const;

  std::string program_, description_, footer_;
  boost::program_options::options_description options_;
  std::map<std::string, Reader> readers_;
  std::string positionals_, positionals_help_;  // empty: there are none
  bool positionals_required_ = false;
  std::set<std::string> repeatable_;
  std::vector<std::pair<std::string, std::string>> not_together_, required_for_;
};

}  // namespace deformable_contact_monitor
