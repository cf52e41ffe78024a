// Tests which known name is suggested for a misspelled one.
#include "robot/nearest_name.h"

#include <gtest/gtest.h>

namespace deformable_contact_monitor {
namespace {

const std::vector<std::string> kKnown = {"max_rate_hz", "robot_rate_hz", "margin_m", "hand", "a"};

TEST(NearestName, TheOneWithTheFewestEdits) {
  EXPECT_EQ(nearestNameHint("max_rate", kKnown), " (did you mean 'max_rate_hz'?)");
  EXPECT_EQ(nearestNameHint("max_rat_hz", kKnown), " (did you mean 'max_rate_hz'?)");
  EXPECT_EQ(nearestNameHint("margin", kKnown), " (did you mean 'margin_m'?)");
  EXPECT_EQ(nearestNameHint("hnad", kKnown), " (did you mean 'hand'?)");
  EXPECT_EQ(nearestNameHint("hands", kKnown), " (did you mean 'hand'?)");
}

TEST(NearestName, NoneIfAllAreTooDifferent) {
  EXPECT_EQ(nearestNameHint("gripper", kKnown), "");
  EXPECT_EQ(nearestNameHint("b", kKnown), "") << "every letter differs";
  EXPECT_EQ(nearestNameHint("", kKnown), "");
  EXPECT_EQ(nearestNameHint("hand", {}), "");
  EXPECT_EQ(nearestNameHint(std::string(1000000, 'x'), kKnown), "");
}

}  // namespace
}  // namespace deformable_contact_monitor
