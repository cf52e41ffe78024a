// Offers the parameters that may change while the monitor runs to dynamic_reconfigure.
#pragma once

#include <deformable_contact_monitor/ContactMonitorConfig.h>
#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// Copies the values to dynamic_reconfigure's structure.
void fill(const LiveParameters& live, ContactMonitorConfig* config);

// Returns the values that `config` asks for. A value that cannot be used keeps its value of
// `in_force`, and adds a line to `rejected`: a number that is not finite, unknown predicates, or a
// class that needs the robot if `has_robot` is false.
LiveParameters fromConfig(const ContactMonitorConfig& config, const LiveParameters& in_force,
                          bool has_robot, std::vector<std::string>* rejected);

// Runs the service ~set_parameters and its topics. A request goes to `apply`, in the thread of the
// handle's queue. The answer and the parameter server have the values that hold afterwards.
class Reconfigure {
 public:
  // Writes the parameters' values to the parameter server, and so replaces what an earlier run left
  // there.
  Reconfigure(const MonitorParameters& parameters, const ros::NodeHandle& private_node,
              std::function<void(const LiveParameters&)> apply);
  Reconfigure(const Reconfigure&) = delete;
  Reconfigure& operator=(const Reconfigure&) = delete;

 private:
  // Applies a request and replaces it by the answer.
  void change(ContactMonitorConfig* config);

  const ros::NodeHandle private_node_;
  const std::function<void(const LiveParameters&)> apply_;
  const bool has_robot_;  // loaded at start
  LiveParameters in_force_;
  std::unique_ptr<dynamic_reconfigure::Server<ContactMonitorConfig>> server_;
};

}  // namespace deformable_contact_monitor
