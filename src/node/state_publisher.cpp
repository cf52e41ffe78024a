// Publishes the states of all pairs after each cycle, and while no cycle ends.
#include "node/state_publisher.h"

#include <ros/this_node.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <chrono>
#include <stdexcept>
#include <string>
#include <utility>

namespace deformable_contact_monitor {
namespace {

constexpr std::chrono::seconds kLongestSilence(1);

// Throws std::runtime_error if this process publishes on the topic already. Two nodelets of one
// manager have its name, so readers could not tell their states apart (RivalMonitors).
std::string freeTopic(const std::string& topic) {
  ros::V_string advertised;
  ros::this_node::getAdvertisedTopics(advertised);
  if (std::find(advertised.begin(), advertised.end(), topic) != advertised.end()) {
    throw std::runtime_error("another monitor of this process publishes " + topic +
                             ": remap contact_states of one of them to another topic");
  }
  return topic;
}

}  // namespace

StatePublisher::StatePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node)
    : tracker_(stateRules(parameters)),
      states_publisher_(private_node.advertise<ContactStates>(
          freeTopic(private_node.resolveName("contact_states")), 2)),
      events_publisher_(private_node.advertise<ContactEvent>("contact_events", 100)) {}

// The tracker has a lock of its own. mutex_ is taken only for making and sending messages.
SteadyTime StatePublisher::publish(const CycleReport& report) {
  tracker_.update(report);
  const std::lock_guard<std::mutex> lock(mutex_);
  publishLocked(report.header.stamp, report.now);
  return std::chrono::steady_clock::now();
}

// The time is taken under the lock, because readers drop a message whose stamp is before the last.
void StatePublisher::forget(const std::string& body, const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::Time now = ros::Time::now();
  tracker_.forget(body, reason, now);
  if (body.empty()) setContacts(nullptr, epoch_);
  publishLocked(now, now);
}

void StatePublisher::discard(const std::string& reason, std::uint64_t epoch) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::Time now = ros::Time::now();
  epoch_ = epoch;
  tracker_.discard(reason, now, epoch);
  setContacts(nullptr, epoch);
  publishLocked(now, now);
}

// Publishes if a state expired, or if nothing was published for a second, so that subscribers can
// tell a quiet monitor from a dead one.
void StatePublisher::beat(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::Time now = ros::Time::now();
  const bool expired = tracker_.expire(now, why);
  if (expired || std::chrono::steady_clock::now() - last_ >= kLongestSilence) {
    publishLocked(now, now);
  }
}

ContactStates StatePublisher::states() const {
  const ros::Time now = ros::Time::now();
  return tracker_.states(now, now);
}

void StatePublisher::setContacts(boost::shared_ptr<const ContactArray> contacts,
                                 std::uint64_t epoch) {
  const std::lock_guard<std::mutex> lock(contacts_mutex_);
  if (!isDiscarded(epoch)) contacts_ = std::move(contacts);
}

boost::shared_ptr<const ContactArray> StatePublisher::contacts() const {
  const std::lock_guard<std::mutex> lock(contacts_mutex_);
  return contacts_;
}

// The caller holds mutex_.
void StatePublisher::publishLocked(const ros::Time& stamp, const ros::Time& now) {
  last_ = std::chrono::steady_clock::now();
  states_publisher_.publish(boost::make_shared<const ContactStates>(tracker_.states(stamp, now)));
  for (const ContactEvent& event : tracker_.takeEvents()) events_publisher_.publish(event);
}

}  // namespace deformable_contact_monitor
