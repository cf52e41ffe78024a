// The tables of an evaluation that does not come to its end.
#include "tools/evaluate_bag/evaluation_tables.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace deformable_contact_monitor {
namespace {

namespace fs = std::filesystem;

TEST(TableFile, HasItsNameOnceItIsWhole) {
  std::string folder = (fs::temp_directory_path() / "table_XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
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
  std::ifstream file(path);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "all\n");
  fs::remove_all(folder);
}

}  // namespace
}  // namespace deformable_contact_monitor
