// How every program of ours reads its command line.
#pragma once

#include <boost/program_options.hpp>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/common/option_value.h"

namespace deformable_contact_monitor {

// Bad usage: throws std::invalid_argument, one line.
[[noreturn]] void refuseUsage(const std::string& what);

// Options, as `--name VALUE` or `--name=VALUE`, and positionals, the words that belong to none.
// Names are with their dashes. Each is read into a variable, which must outlive parse(); what it
// holds before is the default, which --help shows. --help and --version are always there.
class CommandLine {
 public:
  CommandLine(const std::string& program, const std::string& description,
              const std::string& footer = "");

  // The variable becomes true.
  void addFlag(const std::string& name, bool* value, const std::string& help);

  template <class Value>
  void add(const std::string& name, Value* value, const std::string& help,
           const Allowed<Value>& allowed = {}) {
    addOption({name, kindOf<Value>(), 1, 1}, withAllowed(help, allowed.text), toText(*value),
              [=](const Words& words) { *value = read(name, words.front(), allowed); });
  }

  // Without a default.
  template <class Value>
  void add(const std::string& name, std::optional<Value>* value, const std::string& help,
           const Allowed<Value>& allowed = {}) {
    addOption({name, kindOf<Value>(), 1, 1}, withAllowed(help, allowed.text), "",
              [=](const Words& words) { *value = read(name, words.front(), allowed); });
  }

  // Values with commas between them.
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

  // As many words as there are numbers.
  void addNumbers(const std::string& name, std::vector<double>* numbers, const std::string& help);

  // Words up to the next option; it may be given several times.
  void addWords(const std::string& name, std::vector<std::string>* words, const std::string& help);

  // Without this there may be no positionals.
  void addPositionals(const std::string& name, std::vector<std::string>* words, bool required,
                      const std::string& help);

  void refuseTogether(const std::string& one, const std::string& other);
  void requireFor(const std::string& option, const std::string& required);

  // False if --help or --version was asked for and is printed. Throws as refuseUsage() does,
  // naming the option.
  bool parse(int argc, const char* const* argv);

 private:
  using Words = std::vector<std::string>;
  using Reader = std::function<void(const Words&)>;
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
