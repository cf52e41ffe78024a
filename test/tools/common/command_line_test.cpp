// Command lines: what is read, and that what is refused is named in one line.
#include "tools/common/command_line.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>

#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

using Words = std::vector<std::string>;

struct Values {
  std::string text = "before";
  std::optional<int> optional;
  int integer = 7;
  unsigned natural = 8;
  std::uint64_t large = 9;
  float real = 0.5F;
  double positive = 1;
  AdjacentPairs adjacent = AdjacentPairs::kBeyondShared;
  bool flag = false;
  std::vector<int> list = {1, 2};
  std::vector<double> three = {0, 0, 0};
  Words words, repeated, positionals;
  bool answered = false;  // --help or --version
};

Values valuesOf(const Words& arguments, bool required = false) {
  Values values;
  CommandLine line("program", "What it does.", "What else.");
  line.add("--text", &values.text, "a text", oneOf({"before", "a", "b c"}));
  line.add("--optional", &values.optional, "none unless given", inRange(2, 5));
  line.add("--integer", &values.integer, "an integer");
  line.add("--natural", &values.natural, "a natural number");
  line.add("--large", &values.large, "a large number");
  line.add("--real", &values.real, "a number");
  line.add("--positive", &values.positive, "a positive number", isPositive());
  line.add("--adjacent", &values.adjacent, "which");
  line.addFlag("--flag", &values.flag, "a flag");
  line.addList("--list", &values.list, "some", inRange(0, 9));
  line.addNumbers("--three", &values.three, "x y z");
  line.addWords("--words", &values.words, "words");
  line.addRepeated("--repeated", &values.repeated, "texts");
  line.addPositionals("FILE", &values.positionals, required, "files");
  line.refuseTogether("--words", "--flag");
  line.refuseTogether("--text", "FILE");
  line.requireFor("--integer", "--natural");
  std::vector<const char*> argv = {"program"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  values.answered = !line.parse(static_cast<int>(argv.size()), argv.data());
  return values;
}

std::string refusalOf(const Words& arguments, bool required = false) {
  return refusal([&] { valuesOf(arguments, required); });
}

TEST(CommandLine, WhatIsNotGivenStays) {
  const Values values = valuesOf({});
  EXPECT_EQ(values.text, "before");
  EXPECT_FALSE(values.optional);
  EXPECT_EQ(values.list, (std::vector<int>{1, 2}));
  EXPECT_FALSE(values.flag || values.answered);
}

TEST(CommandLine, ReadsEveryKindOfValue) {
  const Values values = valuesOf({"--text=b c", "--optional", "5",
                                  "--integer",  "-3",         "--natural",
                                  "4294967295", "--large",    "18446744073709551615",
                                  "--real",     "-.25e1",     "--positive=1e-3",
                                  "--adjacent", "skip",       "--list",
                                  "3,9,0",      "--three",    "-1",
                                  "2.5",        "-3e2",       "--words",
                                  "a",          "b",          "--words",
                                  "c"});
  EXPECT_EQ(values.text, "b c");
  EXPECT_EQ(values.optional, 5);
  EXPECT_EQ(values.integer, -3);
  EXPECT_EQ(values.natural, 4294967295U);
  EXPECT_EQ(values.large, UINT64_MAX);
  EXPECT_EQ(values.real, -2.5F);
  EXPECT_EQ(values.positive, 1e-3);
  EXPECT_EQ(values.adjacent, AdjacentPairs::kSkip);
  EXPECT_EQ(values.list, (std::vector<int>{3, 9, 0}));
  EXPECT_EQ(values.three, (std::vector<double>{-1, 2.5, -300}));
  EXPECT_EQ(values.words, (Words{"a", "b", "c"}));
}

TEST(CommandLine, PositionalsStandAnywhereButAfterWords) {
  const Values values =
      valuesOf({"a", "--flag", "b", "--three", "1", "2", "3", "c", "--", "--flag", "-x"});
  EXPECT_EQ(values.positionals, (Words{"a", "b", "c", "--flag", "-x"}));
  EXPECT_EQ(valuesOf({"-", "--words", "a", "b"}).positionals, Words{"-"});
}

TEST(CommandLine, ARepeatedOptionTakesNoPositionals) {
  const Values values = valuesOf({"--repeated", "a,b", "file", "--repeated=c"});
  EXPECT_EQ(values.repeated, (Words{"a", "b", "c"}));
  EXPECT_EQ(values.positionals, Words{"file"});
}

TEST(CommandLine, RefusesWithTheOptionsName) {
  for (const auto& [arguments, words] : std::vector<std::pair<Words, std::string>>{
           {{"--text", "c"}, "--text: c is not one of before, a, b c"},
           {{"--optional", "6"}, "--optional: 6 is not in [2, 5]"},
           {{"--optional", "1"}, "--optional: 1 is not in [2, 5]"},
           {{"--natural", "-1"}, "--natural: '-1'"},
           {{"--natural", "4294967296"}, "--natural: '4294967296'"},
           {{"--large", "18446744073709551616"}, "--large: "},
           {{"--natural", "1.5"}, "--natural: '1.5'"},
           {{"--natural", " 1"}, "--natural: ' 1'"},
           {{"--natural", ""}, "--natural: ''"},
           {{"--real", "nan"}, "--real: 'nan'"},
           {{"--real", "inf"}, "--real: 'inf'"},
           {{"--real", "1e99"}, "--real: '1e99'"},
           {{"--real", "1,5"}, "--real: '1,5'"},
           {{"--real", "1 "}, "--real: '1 '"},
           {{"--positive", "0"}, "--positive: 0 is not > 0"},
           {{"--adjacent", "none"}, "--adjacent: 'none'"},
           {{"--list", "1,,2"}, "--list: has an empty value"},
           {{"--list", ""}, "--list: has an empty value"},
           {{"--list", "1,10"}, "--list: 10 is not in [0, 9]"},
           {{"--list", "1,x"}, "--list: 'x'"},
           {{"--three", "1", "2"}, "'--three'"},
           {{"--three", "1", "2", "x"}, "--three: 'x'"},
           {{"--real"}, "'--real'"},
           {{"--real", "1", "--real", "2"}, "--real: is given twice"},
           {{"--words"}, "'--words'"},
           {{"--repeated", "a,,b"}, "--repeated: has an empty value"},
           {{"--flag=1"}, "'--flag'"},
           {{"--fla"}, "'--fla'"},
           {{"-x"}, "'-x'"},
           {{"--words", "a", "--flag"}, "--words and --flag: not together"},
           {{"a", "--text", "a"}, "--text and FILE: not together"},
           {{"--integer", "1"}, "--integer: needs --natural"}}) {
    const std::string refusal = refusalOf(arguments);
    EXPECT_NE(refusal.find(words), std::string::npos) << words << ": " << refusal;
    EXPECT_NE(refusal.find("(see --help)"), std::string::npos) << refusal;
    EXPECT_EQ(refusal.find('\n'), std::string::npos) << refusal;
  }
  EXPECT_EQ(refusalOf({}, true), "FILE is required (see --help)");
}

TEST(CommandLine, WordsBelongSomewhere) {
  CommandLine line("program", "");
  const char* const argv[] = {"program", "word"};
  EXPECT_THROW(line.parse(2, argv), std::invalid_argument);
}

TEST(CommandLine, HelpHasDefaultsAndLimits) {
  for (const char* asked : {"--help", "-h"}) {
    testing::internal::CaptureStdout();
    EXPECT_TRUE(valuesOf({asked, "--integer", "1"}, true).answered);
    const std::string help = testing::internal::GetCapturedStdout();
    for (const char* words :
         {"What it does.", "program [OPTION...] FILE...", "--integer INT", "(default: 7)",
          "in [2, 5]", "(default: 1,2)", "(default: 0 0 0)", "skip|beyond_shared", "What else."}) {
      EXPECT_NE(help.find(words), std::string::npos) << words << "\n" << help;
    }
  }
  testing::internal::CaptureStdout();
  EXPECT_TRUE(valuesOf({"--version"}).answered);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "program " DCM_VERSION "\n");
}

}  // namespace
}  // namespace deformable_contact_monitor
