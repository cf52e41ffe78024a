// Publishes how the pairs stand: after each cycle, and while none ends.
#include "node/state_publisher.h"

#include <boost/make_shared.hpp>

namespace deformable_contact_monitor {
namespace {

constexpr std::chrono::seconds kLongestSilence(1);

StateRules stateRules(const MonitorParameters& parameters) {
  StateRules rules;
  rules.debounce_on_cycles = parameters.debounce_on_cycles;
  rules.debounce_off_cycles = parameters.debounce_off_cycles;
  rules.max_age_s = parameters.max_mesh_age_s;
  rules.tolerated_rejects = parameters.tolerated_rejects;
  rules.since_survives_s = parameters.since_survives_s;
  rules.tolerance_m = parameters.detector.tolerance_m;
  return rules;
}

}  // namespace

StatePublisher::StatePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node)
    : tracker_(stateRules(parameters)),
      states_publisher_(private_node.advertise<ContactStates>("contact_states", 2)),
      events_publisher_(private_node.advertise<ContactEvent>("contact_events", 100)) {}

SteadyTime StatePublisher::publish(const CycleReport& report) {
  tracker_.update(report);
  const std::lock_guard<std::mutex> lock(mutex_);
  publishLocked(report.header.stamp, report.now);
  return std::chrono::steady_clock::now();
}

void StatePublisher::forget(const std::string& body, const std::string& reason) {
  const ros::Time now = ros::Time::now();
  tracker_.forget(body, reason, now);
  const std::lock_guard<std::mutex> lock(mutex_);
  publishLocked(now, now);
}

void StatePublisher::beat(const std::string& why) {
  const ros::Time now = ros::Time::now();
  const bool expired = tracker_.expire(now, why);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (expired || std::chrono::steady_clock::now() - last_ >= kLongestSilence) {
    publishLocked(now, now);
  }
}

ContactStates StatePublisher::states() const {
  const ros::Time now = ros::Time::now();
  return tracker_.states(now, now);
}

void StatePublisher::publishLocked(const ros::Time& stamp, const ros::Time& now) {
  last_ = std::chrono::steady_clock::now();
  states_publisher_.publish(boost::make_shared<const ContactStates>(tracker_.states(stamp, now)));
  for (const ContactEvent& event : tracker_.takeEvents()) events_publisher_.publish(event);
}

}  // namespace deformable_contact_monitor
