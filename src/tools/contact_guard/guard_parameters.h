// The guard's parameters. README.md lists them with unit, default and range.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// All parameters with their defaults. Distances are between two bodies.
struct GuardParameters {
  std::string monitor = "contact_monitor";   // name of the monitor's node
  std::vector<std::string> links;            // only pairs with these links count; empty: all pairs
  std::vector<std::string> required_bodies;  // each must be in one of those pairs
  double slow_distance_m = 0.1;              // full speed at this distance and beyond
  double stop_distance_m = 0.02;             // stop at this distance and below
  double warn_distance_m = 0;                // report at this distance and below; 0: at a stop only
  double least_scale = 0.1;                  // scale just above stop_distance_m
  double receding_m = 0;           // a pair recedes after its distance grew by this; 0: never
  double time_to_contact_s = 0;    // least time until stop_distance_m is reached; 0: any
  double fastest_closing_mps = 1;  // closing speed at full speed while it is not known
  double closing_window_s = 0.2;   // over which closing speeds are measured
  double max_age_s = 0.5;          // of states, in ROS time
  double max_silence_s = 0.5;      // longest silence of the monitor or the ROS clock, wall time
  double rate_hz = 50;             // least rate of the output
  bool latch = false;              // a stop stays until it is released

  std::vector<std::string> changed;  // what is not at its default, each as "name: value"
};

// Thrown with every problem of the parameters, one a line.
struct GuardParameterError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Parses the private namespace as the parameter server returns it (invalid: nothing is set). An
// unknown name is an error too, because a setting that was meant to stop a robot must not be
// ignored. Throws GuardParameterError.
GuardParameters parseGuardParameters(const XmlRpc::XmlRpcValue& tree);

// Returns whether a pair counts: it has one of the guard's links, or there are no links.
bool counts(const GuardParameters& parameters, const ContactState& state);

// Returns a warning that names a pair of `states` whose margin is below the distance up to which
// the guard must see it, and how many such pairs there are; empty: none. That distance is the
// greatest of slow_distance_m, warn_distance_m, and with time_to_contact_s the way of the fastest
// approach. The monitor knows distances only within a pair's margin, so the guard would act too
// late. `monitor` is the monitor's private namespace as the parameter server returns it.
std::string tooSmallMargins(const XmlRpc::XmlRpcValue& monitor, const ContactStates& states,
                            const GuardParameters& parameters);

}  // namespace deformable_contact_monitor
