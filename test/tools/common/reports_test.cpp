// Text for the tables and reports of the tools.
#include "tools/common/reports.h"

#include <gtest/gtest.h>

#include "tools/common/progress.h"

namespace deformable_contact_monitor {
namespace {

TEST(CsvField, IsQuotedWhereItMustBe) {
  EXPECT_EQ(csvField("hand: no mesh yet"), "hand: no mesh yet");
  EXPECT_EQ(csvField("a,b"), "\"a,b\"");
  EXPECT_EQ(csvField("the \"hand\""), "\"the \"\"hand\"\"\"");
  EXPECT_EQ(csvField("two\nlines"), "\"two\nlines\"");
}

TEST(ProgressTest, SaysHowMuchTimeIsLeft) {
  EXPECT_EQ(progressTimes(12.4, {}), " (12 s)");
  EXPECT_EQ(progressTimes(12, {5, 0.5, 0.5}), " (12 s)") << "nothing was done since";
  EXPECT_EQ(progressTimes(12, {5, 0, 0.25}), " (12 s, about 15 s left)");
  EXPECT_EQ(progressTimes(12, {5, 0.5, 0.75}), " (12 s, about 5 s left)");
  EXPECT_EQ(progressTimes(50, {40, 0, 0.0625}), " (50 s, about 10 min left)");
  EXPECT_EQ(progressTimes(50, {40, 0, 1}), " (50 s)") << "what follows is not counted";
}

TEST(ProgressTest, SaysNothingOfWorkThatSoonEnds) {
  testing::internal::CaptureStderr();
  Progress("reading").setDone(0.5);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace deformable_contact_monitor
