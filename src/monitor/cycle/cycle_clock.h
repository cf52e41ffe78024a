// The time rules of the detection loop: waits, heartbeats, jumps of ROS time, and a cycle's time
// budget.
#pragma once

#include <ros/time.h>

#include <chrono>

#include "core/bounds/time_estimates.h"
#include "core/steady_time.h"
#include "monitor/input/usable_stamp.h"

namespace deformable_contact_monitor {

// A wait that has begun, and how long it lasts. CycleClock::startWait() begins one.
struct Wait {
  SteadyTime start;
  ros::Time ros_start;
  SteadyTime::duration length{};  // by the steady clock, and by ROS time
  SteadyTime::duration most{};    // by the steady clock, whatever ROS time does; >= length

  bool isOver(SteadyTime now, const ros::Time& ros_time) const;
  // Returns how much of the wait counts: of both clocks the shorter time, where ROS time may run
  // slower than the steady clock (most > length).
  SteadyTime::duration passed(SteadyTime now, const ros::Time& ros_time) const;
  // Returns when to look again whether it is over; ROS time wakes nobody.
  SteadyTime nextLook(SteadyTime now) const;
};

// Reads no clock: every function uses the times that it is given, so tests need not wait. Intervals
// are measured by the steady clock, since ROS time may stand still, run fast or go back. Where ROS
// time is simulated, waits last for as long by ROS time as well, because a slow simulator delays
// meshes and transforms, but no longer than kMostWait by the steady clock. One thread at a time.
class CycleClock {
 public:
  // `max_mesh_age_s` is the age [s] at which a mesh is too old to be used. `budget_s` is the time
  // [s] from the arrival of a mesh until its states are published; 0: no limit. The first heartbeat
  // is due one second after `start`. `is_simulated` tells that ROS time comes from /clock.
  CycleClock(double max_mesh_age_s, double budget_s, SteadyTime start, bool is_simulated = false);

  // The longest wait by the steady clock, unless a longer one was asked for.
  static constexpr std::chrono::seconds kMostWait{5};

  // Sets ROS time (zero: there is none yet). Returns by how much it went back [s] if that is more
  // than the clocks of two machines may differ, else 0.
  double update(const ros::Time& now);
  // Returns what update(now) would, but sets nothing.
  double backS(const ros::Time& now) const;
  // Returns the time that update() set.
  const ros::Time& rosTime() const { return ros_time_; }
  // Returns false until update() gets a time. Without a clock nobody knows how old a mesh is.
  bool isThere() const { return !ros_time_.isZero(); }

  // Begins a wait of that length [s].
  Wait startWait(double length_s, SteadyTime now) const;

  // Notes that everything was reset, as LeftoverWindow::open() does.
  void startLeftoverWindow(SteadyTime now) { window_.open(now); }
  // Returns whether a message with that stamp is from before the reset.
  bool isLeftover(const ros::Time& stamp, SteadyTime now) const {
    return window_.isLeftover(stamp, ros_time_, now);
  }

  // Puts the heartbeat off, as a cycle begins.
  void startCycle(SteadyTime now);
  bool mustBeat(SteadyTime now) const { return heartbeat_.isOver(now, ros_time_); }
  // Notes that a heartbeat begins; the next one is due a second later.
  void startHeartbeat(SteadyTime now);
  // Returns when to ask mustBeat() again.
  SteadyTime heartbeatDue(SteadyTime now) const { return heartbeat_.nextLook(now); }
  // Returns when to go on after a failure at `now`: a second later, as its cause may last.
  SteadyTime retryTime(SteadyTime now) const;

  // Returns when the detection for a mesh that arrived then must end, so that its states are
  // published within the budget; max(): never. Publishing gets the time that it took in the last
  // hundred cycles, but at most half of the budget.
  SteadyTime deadline(SteadyTime arrival) const;
  // Notes how a cycle with that deadline went. Time that detection takes beyond its deadline counts
  // as publishing time.
  void recordCycle(SteadyTime deadline, SteadyTime detected, SteadyTime published);

 private:
  const double silence_s_;  // from a cycle to the heartbeat after it
  const double budget_s_;
  const bool is_simulated_;
  ros::Time ros_time_;
  Wait heartbeat_;
  LeftoverWindow window_;
  UsualTime publishing_;
};

}  // namespace deformable_contact_monitor
