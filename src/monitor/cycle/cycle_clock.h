// The time rules of the detection loop: heartbeats, jumps of ROS time, and a cycle's time budget.
#pragma once

#include <ros/time.h>

#include <chrono>

#include "core/bounds/time_estimates.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Reads no clock: every function uses the times that it is given, so tests need not wait. Intervals
// are measured by the steady clock, since ROS time may stand still, run fast or go back. One thread
// at a time.
class CycleClock {
 public:
  // `max_mesh_age_s` is the age [s] at which a mesh is too old to be used. `budget_s` is the time
  // [s] from the arrival of a mesh until its states are published; 0: no limit. The first heartbeat
  // is due one second after `start`.
  CycleClock(double max_mesh_age_s, double budget_s, SteadyTime start);

  // Sets ROS time (zero: there is none yet). Returns by how much it went back [s] if that is more
  // than the clocks of two machines may differ, else 0.
  double update(const ros::Time& now);
  // Returns what update(now) would, but sets nothing.
  double backS(const ros::Time& now) const;
  // Returns the time that update() set.
  const ros::Time& rosTime() const { return ros_time_; }

  // Notes that everything was reset. For half a second, messages from before may still arrive.
  void startLeftoverWindow(SteadyTime now);
  // Returns whether a message with that stamp is from before the reset: within that half second,
  // and stamped ahead of ROS time.
  bool isLeftover(const ros::Time& stamp, SteadyTime now) const;

  // Puts the heartbeat off, as a cycle begins.
  void startCycle(SteadyTime now);
  bool mustBeat(SteadyTime now) const { return now >= heartbeat_due_; }
  // Notes that a heartbeat begins; the next one is due a second later.
  void startHeartbeat(SteadyTime now);
  SteadyTime heartbeatDue() const { return heartbeat_due_; }
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
  const std::chrono::steady_clock::duration silence_;  // from a cycle to the heartbeat after it
  const double budget_s_;
  ros::Time ros_time_;
  SteadyTime heartbeat_due_, window_end_;
  UsualTime publishing_;
};

}  // namespace deformable_contact_monitor
