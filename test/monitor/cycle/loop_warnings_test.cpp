// What people are told about missing transforms and unknown names.
#include "monitor/cycle/loop_warnings.h"

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
  bodies[1].kind = BodyKind::kDeformable;
  MonitorParameters parameters;
  parameters.link_margin_m = {{"arm", 0.1}, {"amr", 0.1}, {"cloth", 0.1}};
  EXPECT_EQ(describeUnknownNames(parameters, allowed, bodies),
            (std::vector<std::string>{
                "margins (~link_margin_m) name 'amr' (did you mean 'arm'?), which is no link that "
                "is looked at",
                "margins (~link_margin_m) name 'cloth', which is no link that is looked at",
                "allowed contacts name 'clth' (did you mean 'cloth'?), which is no link or object",
                "allowed contacts name 'hnad', which is no link or object"}));
}

TEST(LoopWarningsTest, ManyUnknownNamesAreCounted) {
  AllowedContacts allowed;
  for (int i = 0; i < 50; ++i) {
    AllowedContact rule;
    rule.body_a = "*";
    rule.body_b = "nothing" + std::to_string(i);
    allowed.add(rule);
  }
  const auto lines = describeUnknownNames({}, allowed, {});
  ASSERT_EQ(lines.size(), 21U);
  EXPECT_EQ(lines.back(), "and 30 more names are unknown");
}

}  // namespace
}  // namespace deformable_contact_monitor
