// A guard on clocks of its own, and states for it.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tools/contact_guard/guard.h"

namespace deformable_contact_monitor {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

inline ContactState stateOf(const std::string& a, const std::string& b, std::uint8_t state,
                            float separation) {
  ContactState made;
  made.body_a = a;
  made.body_b = b;
  made.state = state;
  made.min_separation = separation;
  if (state == ContactState::UNKNOWN) made.reason = "late";
  return made;
}

inline ContactState none(const std::string& a, const std::string& b) {
  return stateOf(a, b, ContactState::NONE, kInfinity);
}

inline ContactState at(float distance_m) {
  return distance_m > 0 ? stateOf("hand", "cloth", ContactState::NEAR, distance_m)
                        : stateOf("hand", "cloth", ContactState::CONTACT, 0);
}

// A guard, and both clocks.
struct Watch {
  explicit Watch(const GuardParameters& parameters) : guard(parameters, steady) {}

  void wait(double s) {
    ros_s += s;
    steady += fromSeconds(s);
  }

  // After a cycle 0.1 s later, or `period_s`.
  GuardOutput hear(std::vector<ContactState> states, double period_s = 0.1) {
    store(std::move(states), period_s);
    return decide();
  }
  void store(std::vector<ContactState> states, double period_s = 0.1) {
    wait(period_s);
    ContactStates message;
    message.cycle = ++cycle;
    message.header.stamp = ros::Time(ros_s);
    for (ContactState& state : states) state.stamp = message.header.stamp;
    message.states = std::move(states);
    guard.store(message, publisher, ros::Time(ros_s), steady);
  }
  GuardOutput hear(const ContactState& state, double period_s = 0.1) {
    return hear(std::vector<ContactState>{state}, period_s);
  }

  GuardOutput decide() { return guard.decide(ros::Time(ros_s), steady); }
  std::string release() { return guard.release(ros::Time(ros_s), steady); }

  double ros_s = 100;
  SteadyTime steady{std::chrono::seconds(7)};
  std::uint64_t cycle = 0;
  std::string publisher = "/contact_monitor";
  Guard guard;
};

}  // namespace deformable_contact_monitor
