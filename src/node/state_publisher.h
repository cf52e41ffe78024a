// Publishes how the pairs stand: after each cycle, and while none ends.
#pragma once

#include <ros/node_handle.h>

#include <mutex>
#include <string>

#include "core/steady_time.h"
#include "monitor/cycle_report.h"
#include "monitor/rules/parameters.h"
#include "monitor/state/contact_state_tracker.h"

namespace deformable_contact_monitor {

// Threads may call every function at any time.
class StatePublisher {
 public:
  StatePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node);

  // ~contact_states and ~contact_events after a report; waits for no other thread's report. Returns
  // when they were out.
  SteadyTime publish(const CycleReport& report);

  // What is known of the pairs of `body`, or of all if it is empty, is forgotten.
  void forget(const std::string& body, const std::string& reason);

  // To be called some hundred times a second: publishes where a state has become too old, which
  // makes it UNKNOWN, because of `why`, and once a second.
  void beat(const std::string& why);

  // As they stand now.
  ContactStates states() const;

 private:
  void publishLocked(const ros::Time& stamp, const ros::Time& now);

  ContactStateTracker tracker_;
  const ros::Publisher states_publisher_, events_publisher_;

  std::mutex mutex_;  // so that messages go out in the order in which they were made
  SteadyTime last_;
};

}  // namespace deformable_contact_monitor
