// Computes a speed scale and a stop from the monitor's states. It has no node handle: the caller
// passes messages and times.
//
// A pair of bodies stops the robot when its state is UNKNOWN, too old, CONTACT, or nearer than
// stop_distance_m. Between stop_distance_m and slow_distance_m the scale grows linearly. With
// time_to_contact_s, a pair that approaches also slows the robot so that this time is left. The
// smaller scale rules. With receding_m, a pair whose distance has grown by as much does not slow
// the robot by its distance.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/steady_time.h"
#include "reader/contact_reader.h"
#include "reader/rival_monitors.h"
#include "tools/contact_guard/closing_speed.h"
#include "tools/contact_guard/guard_parameters.h"

namespace deformable_contact_monitor {

// The guard's output. A default-constructed output stops the robot.
struct GuardOutput {
  bool stop = true;
  double scale = 0;     // of the speed, [0, 1]; 0 with a stop
  std::string because;  // of a stop; else of a scale below 1; else empty
  bool warn = true;     // a stop, or a pair at warn_distance_m or nearer
  std::string near;     // the nearest such pair and its distance; empty: there is none, or a stop
};

// Decides to stop unless all of these hold: every pair that counts is known, fresh and far enough
// apart, ROS time advances, and states arrive from one node. Not thread-safe. The caller passes
// both clocks; the steady one never goes back, ROS time only where it is reset.
class Guard {
 public:
  // `start` is the time from which max_silence_s counts until the first states arrive.
  Guard(const GuardParameters& parameters, SteadyTime start);

  // Takes a message that arrived at `now` (ROS time) and `steady_now` from the node `publisher`.
  void store(const ContactStates& states, const std::string& publisher, const ros::Time& now,
             SteadyTime steady_now);

  // Returns the output at this time. Call it at least as often as the output is due.
  GuardOutput decide(const ros::Time& now, SteadyTime steady_now);

  // Ends a latched stop and returns an empty text, or returns the reason that stops the robot now.
  std::string release(const ros::Time& now, SteadyTime steady_now);

  // Returns whether a latched stop waits for release(). With `latch`, it does so from the start.
  bool isLatched() const { return latched_; }
  // Returns the least certain distance of the pairs that count [m]; 0 if one of them is unknown.
  double nearest(const ros::Time& now) const;

 private:
  // The names of a pair's bodies, in the order of the message.
  using PairName = std::pair<std::string, std::string>;

  // Tracks a pair's distance: the least while it approaches, or the greatest while it recedes.
  struct Course {
    bool recedes = false;
    double turn_m = 0;
  };
  // What a pair allows, and the reason in words.
  struct PairScale {
    double scale = 1;
    std::string because;
  };

  // Parts of store() and decide(). guard.cpp says what each does.
  void forget(const std::string& because);
  void follow(const ContactState& state, double tolerance_m);
  void latch(const std::string& cause);
  void turn(const PairName& name, double distance_m);
  void watchClock(const ros::Time& now, SteadyTime steady_now);
  std::string causeOfStop(const ros::Time& now, SteadyTime steady_now);
  std::string missingBody() const;
  PairScale scaleOf(const ContactState& state, double distance_m) const;
  GuardOutput slowed() const;
  GuardOutput decideNow(const ros::Time& now, SteadyTime steady_now);

  const GuardParameters parameters_;
  ContactReader reader_;
  std::map<PairName, Course> courses_;        // pairs that were NEAR or in CONTACT when last known
  std::map<PairName, ClosingSpeed> closing_;  // with time_to_contact_s, the same pairs
  ScaleHistory scales_;                       // the output so far
  RivalMonitors rivals_;                      // of the monitor
  SteadyTime heard_;                          // arrival of the last message
  SteadyTime clock_moved_;                    // when ROS time last changed
  ros::Time ros_time_;                        // at the last call
  bool latched_;
  std::string latched_because_ = "not released since its start";
};

}  // namespace deformable_contact_monitor
