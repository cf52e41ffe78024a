// Text for the tables and reports of the tools.
#include "tools/common/reports.h"

#include <gtest/gtest.h>

namespace deformable_contact_monitor {
namespace {

TEST(CsvField, IsQuotedWhereItMustBe) {
  EXPECT_EQ(csvField("hand: no mesh yet"), "hand: no mesh yet");
  EXPECT_EQ(csvField("a,b"), "\"a,b\"");
  EXPECT_EQ(csvField("the \"hand\""), "\"the \"\"hand\"\"\"");
  EXPECT_EQ(csvField("two\nlines"), "\"two\nlines\"");
}

}  // namespace
}  // namespace deformable_contact_monitor
