// What people are told about missing transforms and unknown names.
#include "node/loop_warnings.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

TransformReport misses(int count) {
  TransformReport report;
  for (int i = 0; i < count; ++i) {
    TransformReport::Miss miss;
    miss.body = "link" + std::to_string(i);
    miss.answer.problem = "no data";
    report.misses.push_back(miss);
  }
  return report;
}

TEST(LoopWarningsTest, FiveMissesAreListedTheOthersCounted) {
  EXPECT_EQ(describeMisses(misses(1)), "UNKNOWN for want of a transform:\n  link0: no data");
  EXPECT_EQ(describeMisses(misses(5)).find("more"), std::string::npos);
  const std::string seven = describeMisses(misses(7));
  EXPECT_NE(seven.find("\n  link4: no data\n  and 2 more"), std::string::npos) << seven;
  EXPECT_EQ(seven.find("link5"), std::string::npos);
}

TEST(LoopWarningsTest, NamesThatAreNoBodysAreFound) {
  AllowedContacts allowed;
  for (const auto& [a, b] :
       {std::pair<const char*, const char*>{"arm", "*"}, {"cloth", "hnad"}, {"clth", "arm"}}) {
    AllowedContact rule;
    rule.body_a = a;
    rule.body_b = b;
    rule.allowed = true;
    allowed.add(rule);
  }
  std::vector<BodyStatus> bodies(2);
  bodies[0].name = "arm";
  bodies[1].name = "cloth";
  EXPECT_EQ(unknownNames(allowed, bodies), (std::vector<std::string>{"clth", "hnad"}));
}

}  // namespace
}  // namespace deformable_contact_monitor
