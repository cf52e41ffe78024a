// Tests of the guard's parameters, and of its look at the monitor's margins.
#include "tools/contact_guard/guard_parameters.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

std::string refusalOf(const XmlRpc::XmlRpcValue& tree) {
  return refusal<GuardParameterError>([&tree] { parseGuardParameters(tree); });
}

TEST(GuardParametersTest, nothingIsSet) {
  const GuardParameters p = parseGuardParameters(XmlRpc::XmlRpcValue());
  EXPECT_EQ(p.monitor, "contact_monitor");
  EXPECT_TRUE(p.links.empty());
  EXPECT_FALSE(p.latch);
  EXPECT_LT(p.stop_distance_m, p.slow_distance_m);
}

TEST(GuardParametersTest, aNumberWithAnExponentMayBeAText) {
  XmlRpc::XmlRpcValue tree;
  tree["stop_distance_m"] = "1e-3";
  EXPECT_EQ(parseGuardParameters(tree).stop_distance_m, 1e-3);
}

TEST(GuardParametersTest, allBadValuesAreListed) {
  XmlRpc::XmlRpcValue tree;
  tree["slow_distance_m"] = 0.1;
  tree["stop_distance_m"] = 0.2;
  tree["least_scale"] = 2;
  tree["rate_hz"] = 0;
  tree["latch"] = "yes";
  tree["max_age_s"] = -1.0;
  tree["max_silence_s"] = std::string("soon");
  tree["receding_m"] = -0.5;
  tree["warn_distance_m"] = 0.15;
  tree["time_to_contact_s"] = -1;
  tree["fastest_closing_mps"] = 0;
  tree["closing_window_s"] = 0;
  tree["links"] = "hand";
  tree["monitor"] = "a b";
  tree["stop_distance"] = 0.2;
  const std::string refusal = refusalOf(tree);
  EXPECT_NE(refusal.find("14 bad parameter(s)"), std::string::npos) << refusal;
  for (const char* name :
       {"~stop_distance_m is above slow_distance_m", "~least_scale", "~rate_hz", "~latch",
        "~max_age_s", "~max_silence_s", "~receding_m",
        "~warn_distance_m is below stop_distance_m; 0 turns it off", "~time_to_contact_s",
        "~fastest_closing_mps", "~closing_window_s", "~links", "~monitor",
        "~stop_distance (did you mean 'stop_distance_m'?) is no parameter"}) {
    EXPECT_NE(refusal.find(std::string("\n  ") + name), std::string::npos) << name << refusal;
  }
}

// The monitor's parameters, with a margin of 0.05 m and one of its own for a link and an object.
XmlRpc::XmlRpcValue monitor() {
  XmlRpc::XmlRpcValue tree;
  tree["margin_m"] = 0.05;
  tree["link_margin_m"]["finger"] = 0.2;
  tree["objects"][0]["name"] = "cloth";
  tree["objects"][1]["name"] = "cable";
  tree["objects"][1]["margin_m"] = 0.1;
  return tree;
}

ContactStates pairs(const std::vector<std::vector<std::string>>& names) {
  ContactStates states;
  for (const std::vector<std::string>& pair : names) {
    ContactState state;
    state.body_a = pair[0];
    state.body_b = pair[1];
    states.states.push_back(state);
  }
  return states;
}

TEST(MarginCheckTest, namesAPairThatIsSeenTooLate) {
  GuardParameters p;  // slows from 0.1 m
  const ContactStates states =
      pairs({{"hand", "cable"}, {"finger", "cloth"}, {"hand", "cloth"}, {"arm", "cloth"}});
  const std::string text = tooSmallMargins(monitor(), states, p);
  EXPECT_NE(text.find("2 pair(s), such as hand and cloth (0.05 m)"), std::string::npos) << text;
  p.links = {"finger", "cable"};
  EXPECT_EQ(tooSmallMargins(monitor(), states, p), "");
  p.links.clear();
  p.slow_distance_m = 0.05;
  EXPECT_EQ(tooSmallMargins(monitor(), states, p), "");
}

TEST(MarginCheckTest, knowsWhichDistanceIsTheGreatest) {
  GuardParameters p;
  p.warn_distance_m = 0.15;
  const ContactStates states = pairs({{"hand", "cable"}});
  std::string text = tooSmallMargins(monitor(), states, p);
  EXPECT_NE(text.find("(0.1 m), is below warn_distance_m (0.15 m): nothing warns"),
            std::string::npos)
      << text;
  p.time_to_contact_s = 0.5;
  p.fastest_closing_mps = 0.4;
  text = tooSmallMargins(monitor(), states, p);
  EXPECT_NE(text.find("time_to_contact_s at fastest_closing_mps, with stop_distance_m (0.22 m)"),
            std::string::npos)
      << text;
  EXPECT_EQ(tooSmallMargins(monitor(), pairs({{"finger", "cloth"}}), GuardParameters()), "");
}

TEST(MarginCheckTest, withoutAMarginNothingIsSeen) {
  const ContactStates states = pairs({{"hand", "cloth"}});
  const std::string text = tooSmallMargins(XmlRpc::XmlRpcValue(), states, GuardParameters());
  EXPECT_NE(text.find("hand and cloth (0 m)"), std::string::npos) << text;
}

}  // namespace
}  // namespace deformable_contact_monitor
