// How every program of ours reads its command line.
#include "tools/common/command_line.h"

#include <iostream>
#include <limits>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

namespace po = boost::program_options;

// Boost's own values take one word, or any number.
class WordsValue : public po::typed_value<std::vector<std::string>> {
 public:
  WordsValue(unsigned least, unsigned most) : typed_value(nullptr), least_(least), most_(most) {}
  unsigned min_tokens() const override { return least_; }
  unsigned max_tokens() const override { return most_; }

 private:
  unsigned least_, most_;
};

}  // namespace

void refuseUsage(const std::string& what) { throw std::invalid_argument(what + " (see --help)"); }

CommandLine::CommandLine(const std::string& program, const std::string& description,
                         const std::string& footer)
    : program_(program), description_(description), footer_(footer), options_("Options") {
  options_.add_options()("help,h", "Print this and exit")("version", "Print the version and exit");
}

void CommandLine::addOption(const Shape& shape, const std::string& help, const std::string& value,
                            const Reader& reader) {
  auto* words = new WordsValue(shape.least_words, shape.most_words);  // Boost deletes it
  words->value_name(shape.kind);
  const std::string whole = value.empty() ? help : help + " (default: " + value + ")";
  options_.add_options()(shape.name.substr(2).c_str(), words, whole.c_str());
  readers_[shape.name] = reader;
}

void CommandLine::addFlag(const std::string& name, bool* value, const std::string& help) {
  addOption({name, "", 0, 0}, help, "", [value](const Words& /*none*/) { *value = true; });
}

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

void CommandLine::addWords(const std::string& name, std::vector<std::string>* words,
                           const std::string& help) {
  addOption({name, "TEXT...", 1, std::numeric_limits<int>::max()}, help, "",
            [words](const Words& given) { *words = given; });
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
  using namespace po::command_line_style;
  try {
    const po::parsed_options parsed = po::command_line_parser(argc, argv)
                                          .options(options_)
                                          .style(unix_style & ~allow_guessing)
                                          .run();
    if (printAnswer(parsed)) return false;
    readAll(parsed);
  } catch (const po::error& error) {
    refuseUsage(error.what());
  }
  return true;
}

// Of --help and --version.
bool CommandLine::printAnswer(const po::parsed_options& parsed) const {
  for (const po::option& option : parsed.options) {
    if (option.string_key == "help") printHelp();
    if (option.string_key == "version") std::cout << program_ << " " << DCM_VERSION << "\n";
    if (option.string_key == "help" || option.string_key == "version") return true;
  }
  return false;
}

void CommandLine::readAll(const po::parsed_options& parsed) const {
  std::map<std::string, Words> words;
  std::set<std::string> given;
  for (const po::option& option : parsed.options) {
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

void CommandLine::checkRules(const std::set<std::string>& given) const {
  const auto is_given = [&given](const std::string& name) { return given.count(name) != 0; };
  if (positionals_required_ && !is_given(positionals_)) refuseUsage(positionals_ + " is required");
  for (const auto& [one, other] : not_together_) {
    if (is_given(one) && is_given(other)) refuseUsage(one + " and " + other + ": not together");
  }
  for (const auto& [option, required] : required_for_) {
    if (is_given(option) && !is_given(required)) refuseUsage(option + ": needs " + required);
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
