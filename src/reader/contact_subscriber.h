// Subscribes to a monitor's ~contact_states, and asks a ContactReader at the present ROS time.
#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/transport_hints.h>

#include <mutex>
#include <string>
#include <vector>

#include "reader/contact_reader.h"

namespace deformable_contact_monitor {

// Needs a spinner that runs its callback. Any thread may call any function at any time. If ROS time
// stands still, no state grows old here. A program that moves a robot in real time must therefore
// watch the clock as well, or obey contact_guard, which does.
class ContactSubscriber {
 public:
  // Subscribes to `topic`, such as "contact_monitor/contact_states".
  ContactSubscriber(ros::NodeHandle node, const std::string& topic,
                    const ReaderRules& rules = ReaderRules())
      : reader_(rules),
        subscriber_(node.subscribe(topic, 1, &ContactSubscriber::store, this,
                                   ros::TransportHints().tcpNoDelay())) {}
  ContactSubscriber(const ContactSubscriber&) = delete;
  ContactSubscriber& operator=(const ContactSubscriber&) = delete;

  // These functions answer as those of ContactReader do.
  MoveAnswer mayMove(const std::string& body) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return reader_.mayMove(body, ros::Time::now());
  }

  double nearest(const std::string& body) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return reader_.nearest(body, ros::Time::now());
  }

  std::vector<ContactState> contacts(const std::string& body) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return reader_.contacts(body, ros::Time::now());
  }

 private:
  void store(const ContactStates& states) {
    const std::lock_guard<std::mutex> lock(mutex_);
    reader_.store(states, ros::Time::now());
  }

  mutable std::mutex mutex_;  // guards reader_
  ContactReader reader_;
  ros::Subscriber subscriber_;
};

}  // namespace deformable_contact_monitor
