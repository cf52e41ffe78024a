// Reads and checks the guard's parameters. All problems are collected before it throws, so that a
// user can correct them at once.
#include "tools/contact_guard/guard_parameters.h"

#include <ros/names.h>

#include "monitor/rules/parameter_reader.h"

namespace deformable_contact_monitor {

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

}  // namespace deformable_contact_monitor
