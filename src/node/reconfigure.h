// dynamic_reconfigure of the parameters that may change while the monitor runs.
#pragma once

#include <deformable_contact_monitor/ContactMonitorConfig.h>
#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "monitor/rules/live_parameters.h"

namespace deformable_contact_monitor {

void fill(const LiveParameters& live, ContactMonitorConfig* config);

// What `config` asks for. Values that cannot be used (not finite, out of range, no such predicates,
// a class that needs the robot where there is `has_robot` none) stay as they are in `in_force`;
// `refused` gets a line for each.
LiveParameters fromConfig(const ContactMonitorConfig& config, const LiveParameters& in_force,
                          bool has_robot, std::vector<std::string>* refused);

// The service ~set_parameters and its topics. What is asked for goes to `apply`, in the thread of
// the handle's queue; the answer, and the parameter server, have what holds then.
class Reconfigure {
 public:
  // Writes the start values to the parameter server: those of the parameters are in force, whatever
  // an earlier run left there.
  Reconfigure(const MonitorParameters& parameters, const ros::NodeHandle& private_node,
              std::function<void(const LiveParameters&)> apply);
  Reconfigure(const Reconfigure&) = delete;
  Reconfigure& operator=(const Reconfigure&) = delete;

 private:
  void change(ContactMonitorConfig* config);

  const ros::NodeHandle private_node_;
  const std::function<void(const LiveParameters&)> apply_;
  const bool has_robot_;
  LiveParameters in_force_;
  std::unique_ptr<dynamic_reconfigure::Server<ContactMonitorConfig>> server_;
};

}  // namespace deformable_contact_monitor
