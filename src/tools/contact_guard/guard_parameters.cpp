// Reads and checks the guard's parameters. All problems are collected before it throws, so that a
// user can correct them at once. The margins that the parameters need are checked later: the margin
// of a pair is the larger one of its two bodies, as in the monitor.
#include "tools/contact_guard/guard_parameters.h"

#include <ros/names.h>

#include <algorithm>
#include <sstream>

#include "monitor/rules/parameter_reader.h"
#include "reader/contact_reader.h"
#include "reader/monitor_margins.h"

namespace deformable_contact_monitor {
namespace {

// A distance up to which the guard must see pairs, where it comes from, and what happens otherwise.
struct Reach {
  double distance_m;
  std::string name, without;
};

// Returns the greatest distance that the guard needs.
Reach reachOf(const GuardParameters& p) {
  Reach reach{p.slow_distance_m, "slow_distance_m", "nothing slows the robot beyond that margin"};
  if (p.warn_distance_m > reach.distance_m) {
    reach = {p.warn_distance_m, "warn_distance_m", "nothing warns beyond that margin"};
  }
  const double way_m = p.fastest_closing_mps * p.time_to_contact_s;
  if (p.time_to_contact_s > 0 && p.stop_distance_m + way_m > reach.distance_m) {
    reach = {p.stop_distance_m + way_m,
             "the way in time_to_contact_s at fastest_closing_mps, with stop_distance_m",
             "a pair that comes as fast slows the robot too late"};
  }
  return reach;
}

}  // namespace

GuardParameters parseGuardParameters(const XmlRpc::XmlRpcValue& tree) {
  std::vector<std::string> found;
  ParameterReader reader(tree, "~", &found);
  GuardParameters p;
  p.monitor = reader.text("monitor", p.monitor);
  std::string error;
  if (!ros::names::validate(p.monitor, error))
    reader.addProblem("monitor", "is not a valid name: " + error);
  p.links = reader.texts("links");
  p.required_bodies = reader.texts("required_bodies");
  p.slow_distance_m = reader.number("slow_distance_m", p.slow_distance_m, 0, 10);
  p.stop_distance_m = reader.number("stop_distance_m", p.stop_distance_m, 0, 10);
  if (p.stop_distance_m > p.slow_distance_m) {
    reader.addProblem("stop_distance_m", "is above slow_distance_m");
  }
  p.warn_distance_m = reader.number("warn_distance_m", p.warn_distance_m, 0, 10);
  if (p.warn_distance_m > 0 && p.warn_distance_m < p.stop_distance_m) {
    reader.addProblem("warn_distance_m", "is below stop_distance_m; 0 turns it off");
  }
  p.least_scale = reader.number("least_scale", p.least_scale, 0, 1);
  p.receding_m = reader.number("receding_m", p.receding_m, 0, 1);
  p.time_to_contact_s = reader.number("time_to_contact_s", p.time_to_contact_s, 0, 60);
  p.fastest_closing_mps = reader.number("fastest_closing_mps", p.fastest_closing_mps, 0.001, 100);
  p.closing_window_s = reader.number("closing_window_s", p.closing_window_s, 0.01, 10);
  p.max_age_s = reader.number("max_age_s", p.max_age_s, 0.001, 60);
  p.max_silence_s = reader.number("max_silence_s", p.max_silence_s, 0.01, 60);
  p.rate_hz = reader.number("rate_hz", p.rate_hz, 1, 1000);
  p.latch = reader.flag("latch", p.latch);
  for (const std::string& name : reader.unknown()) found.push_back(name + " is no parameter");
  p.changed = reader.changed();
  if (found.empty()) return p;
  std::string all = std::to_string(found.size()) + " bad parameter(s):";
  for (const std::string& problem : found) all += "\n  " + problem;
  throw GuardParameterError(all);
}

bool counts(const GuardParameters& parameters, const ContactState& state) {
  const std::vector<std::string>& links = parameters.links;
  return links.empty() || std::any_of(links.begin(), links.end(), [&state](const auto& link) {
           return ContactReader::concerns(state, link);
         });
}

std::string tooSmallMargins(const XmlRpc::XmlRpcValue& monitor, const ContactStates& states,
                            const GuardParameters& parameters) {
  const Reach reach = reachOf(parameters);
  const std::string pairs =
      pairsBelow(reach.distance_m, marginsOf(monitor), states,
                 [&parameters](const ContactState& state) { return counts(parameters, state); });
  if (pairs.empty()) return "";
  std::ostringstream text;
  text << "the monitor's margin_m of " << pairs << ", is below " << reach.name << " ("
       << reach.distance_m << " m): " << reach.without;
  return text.str();
}

}  // namespace deformable_contact_monitor
