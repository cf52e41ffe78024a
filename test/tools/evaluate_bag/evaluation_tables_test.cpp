// The tables of an evaluation: links.csv where cycles are missing, and files without an end.
#include "tools/evaluate_bag/evaluation_tables.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu_detector.h"

namespace deformable_contact_monitor {
namespace {

namespace fs = std::filesystem;

std::string newFolder() {
  std::string folder = (fs::temp_directory_path() / "table_XXXXXX").string();
  EXPECT_NE(mkdtemp(folder.data()), nullptr);
  return folder;
}

std::string contentOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Returns links.csv without its title and without the names of run and bodies. Each cycle has a
// stamp and the state of the only pair; a state holds for half a second.
std::string links(const std::vector<std::pair<double, std::uint8_t>>& cycles) {
  const std::string folder = newFolder();
  EvaluationTables::Runs runs;
  runs.push_back(std::make_unique<EvaluationRun>("cpu", makeCpuDetector(), Options(), StateRules(),
                                                 std::vector<Expectation>()));
  EvaluationRun& run = *runs[0];
  run.result = std::make_shared<DetectionResult>();
  run.states.states.resize(1);
  ContactState& state = run.states.states[0];
  state.body_a = "a";
  state.body_b = "b";
  EvaluationTables tables(folder, false, false, 0.5);
  for (const auto& [stamp_s, of] : cycles) {
    CycleReport cycle;
    cycle.header.stamp = run.states.header.stamp = state.stamp = ros::Time(stamp_s);
    state.state = of;
    tables.add(cycle, runs, {false});
  }
  tables.finish();
  std::string rows = contentOf(folder + "/links.csv");
  rows.erase(0, rows.find('\n') + 1);
  for (std::size_t at = 0; (at = rows.find("cpu exact,a,b,")) != std::string::npos;) {
    rows.erase(at, std::string("cpu exact,a,b,").size());
  }
  fs::remove_all(folder);
  return rows;
}

TEST(EvaluationTables, APairIsUnknownWhereItsCyclesAreMissing) {
  constexpr auto kNone = ContactState::NONE, kContact = ContactState::CONTACT,
                 kUnknown = ContactState::UNKNOWN;
  EXPECT_EQ(links({{1, kContact}, {1.5, kContact}, {4, kContact}}),
            "CONTACT,1.000000000,1.500000000,2,0,0,0.000000000,0.500000000\n"
            "UNKNOWN,2.000000000,4.000000000,0,0,0,1.000000000,3.000000000\n"
            "CONTACT,4.000000000,4.000000000,1,0,0,3.000000000,3.000000000\n");
  EXPECT_EQ(links({{1, kNone}, {3, kUnknown}, {5, kUnknown}}),
            "NONE,1.000000000,1.000000000,1,0,0,0.000000000,0.000000000\n"
            "UNKNOWN,3.000000000,5.000000000,2,0,0,2.000000000,4.000000000\n");
  EXPECT_EQ(links({{9, kNone}, {1, kNone}, {1.5, kNone}}),
            "NONE,9.000000000,9.000000000,1,0,0,0.000000000,0.000000000\n"
            "NONE,1.000000000,1.500000000,2,0,0,-8.000000000,-7.500000000\n")
      << "the clock went back";
}

TEST(TableFile, HasItsNameOnceItIsWhole) {
  const std::string folder = newFolder();
  const std::string path = folder + "/table.csv";
  {
    TableFile table(path);
    table.line("half of it");
  }
  EXPECT_TRUE(fs::is_empty(folder));
  {
    TableFile table(path);
    table.line("all");
    EXPECT_FALSE(fs::exists(path));
    table.finish();
  }
  EXPECT_EQ(contentOf(path), "all\n");
  fs::remove_all(folder);
}

}  // namespace
}  // namespace deformable_contact_monitor
