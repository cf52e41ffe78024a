// Tests which transforms may enter the buffer.
#include <gtest/gtest.h>

#include "monitor/input/usable_stamp.h"

namespace deformable_contact_monitor {
namespace {

TEST(TransformInputTest, OnlyWhatIsFarAheadOfTheClockIsLeftOut) {
  const ros::Time now(100);
  EXPECT_TRUE(isUsableStamp(ros::Time(1), now)) << "tf2 leaves out what is too old";
  EXPECT_TRUE(isUsableStamp(now, now));
  EXPECT_TRUE(isUsableStamp(ros::Time(101), now)) << "clocks differ, and some predict";
  EXPECT_FALSE(isUsableStamp(ros::Time(101.1), now));
  EXPECT_FALSE(isUsableStamp(ros::Time(4.2e9), now));
}

TEST(TransformInputTest, WithoutAClockNothingIsAhead) {
  EXPECT_TRUE(isUsableStamp(ros::Time(4.2e9), ros::Time()));
}

}  // namespace
}  // namespace deformable_contact_monitor
