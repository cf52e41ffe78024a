// Publishes the states of all pairs after each cycle, and while no cycle ends. Answers
// ~get_contacts.
#pragma once

#include <deformable_contact_monitor/ContactArray.h>
#include <deformable_contact_monitor/ContactStates.h>
#include <ros/node_handle.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>

#include "core/steady_time.h"
#include "monitor/cycle_report.h"
#include "monitor/rules/parameters.h"
#include "monitor/state/contact_state_tracker.h"

namespace deformable_contact_monitor {

// The part of the output that several threads use: the detection thread publishes cycles, a timer
// thread lets states expire, and services read what holds now. Any thread may call any function.
class StatePublisher {
 public:
  StatePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node);

  // Publishes ~contact_states and ~contact_events after a cycle. Returns when the messages were
  // out.
  SteadyTime publish(const CycleReport& report);

  // Forgets the states of the pairs of `body`, or of all and the contacts too if it is empty, and
  // publishes that.
  void forget(const std::string& body, const std::string& reason);

  // Forgets all states and contacts and publishes that, as a service answers. Cycles of earlier
  // epochs that are still running make nothing known any more.
  void discard(const std::string& reason, std::uint64_t epoch);

  // Publishes the states if one of them has become too old, and at least once a second. A state
  // that is too old becomes UNKNOWN because of `why`. Call it some hundred times a second.
  void beat(const std::string& why);

  // Returns the states as they are now.
  ContactStates states() const;

  // Returns whether what a cycle of that epoch finds is discarded.
  bool isDiscarded(std::uint64_t epoch) const { return epoch < epoch_; }

  // Keeps the contacts that a cycle of that epoch published, unless they are discarded.
  void setContacts(boost::shared_ptr<const ContactArray> contacts, std::uint64_t epoch);
  // Returns the contacts that were published last; null if all are forgotten.
  boost::shared_ptr<const ContactArray> contacts() const;

 private:
  // Publishes the states with the stamp `stamp`, as they are at `now` (ROS time), then the new
  // events. The caller holds mutex_.
  void publishLocked(const ros::Time& stamp, const ros::Time& now);

  ContactStateTracker tracker_;
  const ros::Publisher states_publisher_, events_publisher_;

  std::mutex mutex_;  // makes messages go out in the order in which they were made
  SteadyTime last_;   // when the last states were published

  std::atomic<std::uint64_t> epoch_{0};
  mutable std::mutex contacts_mutex_;
  boost::shared_ptr<const ContactArray> contacts_;
};

}  // namespace deformable_contact_monitor
