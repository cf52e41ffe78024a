// From states to a speed scale and a stop. No node of its own: times and messages are given.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>

#include <map>
#include <string>
#include <utility>

#include "core/steady_time.h"
#include "reader/contact_reader.h"
#include "tools/contact_guard/guard_parameters.h"

namespace deformable_contact_monitor {

struct GuardOutput {
  bool stop = true;
  double scale = 0;     // of the speed, [0, 1]; 0 with a stop
  std::string because;  // of a stop; else of a scale below 1; else empty
};

// Stops unless every pair that counts is known, fresh and far enough apart, ROS time goes on, and
// states come. One thread at a time; its clocks are told to it, each going forward but for resets
// of ROS time.
class Guard {
 public:
  // `start`: waiting for the first states begins.
  Guard(const GuardParameters& parameters, SteadyTime start);

  void store(const ContactStates& states, const ros::Time& now, SteadyTime steady_now);

  GuardOutput decide(const ros::Time& now, SteadyTime steady_now);

  // Ends a latched stop; why it does not: something stops the robot now. Empty: nothing is latched.
  std::string release(const ros::Time& now, SteadyTime steady_now);

  bool isLatched() const { return latched_; }
  // The least certain distance [m] of the pairs that count; 0 where anything is not known.
  double nearest(const ros::Time& now) const;

 private:
  using PairName = std::pair<std::string, std::string>;

  // How a pair's distance went: the least since it came nearer, or the greatest since it receded.
  struct Course {
    bool recedes = false;
    double turn_m = 0;
  };

  bool counts(const ContactState& state) const;
  void follow(const ContactState& state, double tolerance_m);
  void watchClock(const ros::Time& now, SteadyTime steady_now);
  std::string causeOfStop(const ros::Time& now, SteadyTime steady_now);
  std::string missingBody() const;
  GuardOutput slowed() const;

  const GuardParameters parameters_;
  ContactReader reader_;
  std::map<PairName, Course> courses_;  // of pairs that were NEAR or touched when last known
  SteadyTime heard_;                    // the last message came
  SteadyTime clock_moved_;              // ROS time was last seen to change
  ros::Time ros_time_;                  // as last seen
  bool latched_;
  std::string latched_because_ = "not released since its start";
};

}  // namespace deformable_contact_monitor
