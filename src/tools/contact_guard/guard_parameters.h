// The guard's parameters. README.md holds each with unit, default and range.
#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

struct GuardParameters {
  std::string monitor = "contact_monitor";   // name of the monitor's node
  std::vector<std::string> links;            // whose pairs count; empty: all pairs
  std::vector<std::string> required_bodies;  // each must be in one of those pairs
  double slow_distance_m = 0.1;              // at least so far apart: full speed
  double stop_distance_m = 0.02;             // at most so far apart: stop
  double least_scale = 0.1;                  // at stop_distance_m, before the stop
  double receding_m = 0.005;                 // grown by so much, a distance slows no more; 0: never
  double max_age_s = 0.5;                    // of states, in ROS time
  double max_silence_s = 0.5;  // of the monitor and of the ROS clock, by the wall clock
  double rate_hz = 50;         // of the output, at least
  bool latch = false;          // a stop stays until it is released
};

// Lists every problem, one a line.
struct GuardParameterError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// `tree`: the private namespace as the parameter server hands it out (invalid: nothing is set). A
// name that nothing reads is a problem, too: what was meant to stop a robot is not ignored. Throws
// GuardParameterError.
GuardParameters parseGuardParameters(const XmlRpc::XmlRpcValue& tree);

}  // namespace deformable_contact_monitor
