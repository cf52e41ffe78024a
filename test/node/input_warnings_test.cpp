// Tests which warnings about input are due, and what they say.
#include "node/input_warnings.h"

#include <gtest/gtest.h>

#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr const char* kMeshType = "deformable_contact_monitor/DeformableMesh";

InputStatus cloth() {
  InputStatus input;
  input.object = "cloth";
  input.topic = "/robot/cloth";
  input.wanted_type = kMeshType;
  return input;
}

class InputWarningsTest : public ::testing::Test {
 protected:
  // One look a second from `from_s` to `to_s`; all warnings.
  std::vector<std::string> lookAt(InputStatus input, int from_s, int to_s, bool meshes_come) {
    std::vector<std::string> all;
    for (int s = from_s; s <= to_s; ++s) {
      if (meshes_come) received_ += 30;
      input.received = received_;
      const ros::Time ros_time(clock_runs_ ? 100 + s : 100);
      for (std::string& text : warnings_.look({input}, {ros_time, is_simulated_, is_sim_time_set_},
                                              start_ + seconds(s))) {
        all.push_back(std::move(text));
      }
    }
    return all;
  }

  const SteadyTime start_{std::chrono::hours(1)};
  InputWarnings warnings_{start_};
  std::uint64_t received_ = 0;
  bool clock_runs_ = true, is_simulated_ = false, is_sim_time_set_ = false;
};

TEST_F(InputWarningsTest, NothingIsSaidWhileMeshesCome) {
  EXPECT_TRUE(lookAt(cloth(), 0, 30, true).empty());
}

TEST_F(InputWarningsTest, AMissingMeshIsNamedEveryFiveSeconds) {
  const std::vector<std::string> all = lookAt(cloth(), 0, 24, false);
  ASSERT_EQ(all.size(), 4U);  // at 5, 10, 15 and 20 s
  EXPECT_EQ(all[0], "object 'cloth': no mesh for 5 s on /robot/cloth, on which nobody publishes");
  EXPECT_EQ(lookAt(cloth(), 25, 29, true).size(), 0U);
  EXPECT_EQ(lookAt(cloth(), 30, 35, false).size(), 1U) << "they came until 29 s";
}

TEST_F(InputWarningsTest, WhatIsMissingAtTheStartIsNamed) {
  InputStatus optional = cloth(), there = cloth();
  optional.required = false;
  there.received = 1;
  EXPECT_EQ(
      missingInputs({cloth(), optional, there}),
      std::vector<std::string>{"a mesh of 'cloth' on /robot/cloth, on which nobody publishes"});
  optional.type = "std_msgs/String";
  EXPECT_EQ(missingInputs({optional}).size(), 1U) << "somebody publishes the wrong thing";
}

TEST_F(InputWarningsTest, APublisherOfAnotherTypeIsNamed) {
  InputStatus input = cloth();
  input.type = "std_msgs/String";
  const std::vector<std::string> all = lookAt(input, 0, 5, false);
  ASSERT_EQ(all.size(), 1U);
  expectIn(std::string("std_msgs/String is published, and not ") + kMeshType, all[0]);
}

TEST_F(InputWarningsTest, TheTypeThatIsWantedIsTheObjectsOwn) {
  InputStatus input = cloth();
  input.wanted_type = "sensor_msgs/PointCloud2";
  input.type = kMeshType;
  const std::vector<std::string> all = lookAt(input, 0, 5, false);
  ASSERT_EQ(all.size(), 1U);
  expectIn(std::string(kMeshType) + " is published, and not sensor_msgs/PointCloud2", all[0]);
}

TEST_F(InputWarningsTest, SilentPublishersAreCounted) {
  InputStatus input = cloth();
  input.type = kMeshType;
  input.publishers = 2;
  const std::vector<std::string> all = lookAt(input, 0, 5, false);
  ASSERT_EQ(all.size(), 1U);
  expectIn("2 publisher(s)", all[0]);
}

TEST_F(InputWarningsTest, WhatNeedNotBeThereMayBeMissingUnlessSomebodyPublishes) {
  InputStatus input = cloth();
  input.required = false;
  EXPECT_TRUE(lookAt(input, 0, 20, false).empty());
  input.type = "std_msgs/String";
  EXPECT_FALSE(lookAt(input, 21, 26, false).empty());
}

TEST_F(InputWarningsTest, ARefusalIsNamedAtOnceAndThenEveryFiveSeconds) {
  InputStatus input = cloth();
  input.refusal = "header.stamp is zero";
  input.type = kMeshType;
  input.publishers = 1;
  EXPECT_EQ(lookAt(input, 0, 0, true),
            (std::vector<std::string>{
                std::string("object 'cloth': mesh refused: header.stamp is zero; it came on "
                            "/robot/cloth, on which 1 publisher(s) of ") +
                kMeshType + " are connected"}));
  EXPECT_EQ(lookAt(input, 1, 20, true).size(), 4U);
}

TEST_F(InputWarningsTest, WhatIsOddIsNamed) {
  InputStatus input = cloth();
  input.anomaly = "its mesh is 800 m long";
  EXPECT_EQ(lookAt(input, 0, 4, true),
            std::vector<std::string>{"object 'cloth': its mesh is 800 m long"});
}

TEST_F(InputWarningsTest, PublishersThatContradictEachOtherAreNamed) {
  InputStatus input = cloth();
  input.rivals = "two nodes: /a and /b";
  EXPECT_EQ(lookAt(input, 0, 9, true),
            (std::vector<std::string>{"object 'cloth': two nodes: /a and /b (/robot/cloth)",
                                      "object 'cloth': two nodes: /a and /b (/robot/cloth)"}));
  input.refusal = "header.stamp is zero";
  const std::vector<std::string> all = lookAt(input, 10, 10, true);
  ASSERT_EQ(all.size(), 1U);
  expectIn("header.stamp is zero", all[0]);
  expectIn("two nodes: /a and /b", all[0]);
}

TEST_F(InputWarningsTest, ASilentClockIsTheOneWarningAboutWhatIsMissing) {
  is_simulated_ = true;
  clock_runs_ = false;
  const std::vector<std::string> all = lookAt(cloth(), 0, 14, false);
  ASSERT_EQ(all.size(), 2U);
  expectIn("/clock is silent for 5 s", all[0]);
  clock_runs_ = true;
  const std::vector<std::string> missing = lookAt(cloth(), 15, 15, false);
  ASSERT_EQ(missing.size(), 1U);
  expectIn("no mesh for 15 s", missing[0]);
}

TEST_F(InputWarningsTest, ANodeThatStartedBeforeSimulatedTimeWasSetIsToBeRestarted) {
  is_sim_time_set_ = true;
  const std::vector<std::string> all = lookAt(cloth(), 0, 9, true);
  ASSERT_EQ(all.size(), 2U) << "every 5 s";
  expectIn("this node was started before /use_sim_time was set", all[0]);
  expectIn("restart it", all[0]);
  is_simulated_ = true;
  EXPECT_TRUE(lookAt(cloth(), 10, 20, true).empty()) << "it was set in time";
}

TEST_F(InputWarningsTest, AClockThatStandsStillWithoutUseSimTimeIsNoMatter) {
  clock_runs_ = false;
  EXPECT_TRUE(lookAt(cloth(), 0, 20, true).empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
