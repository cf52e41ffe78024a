// When there is to be a heartbeat, and when time has jumped.
#pragma once

#include <ros/time.h>

#include <chrono>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Reads no clock: every function goes by the times that it is given. Intervals are of the steady
// clock, since ROS time may stand still, run fast or go back.
class CycleClock {
 public:
  // The first heartbeat is due a second after `start`.
  CycleClock(double max_mesh_age_s, SteadyTime start);

  // Sets ROS time (zero: there is none yet). Returns by how much it went back [s] if that is more
  // than clocks of two machines differ, else 0.
  double update(const ros::Time& now);
  // As update() was last told.
  const ros::Time& rosTime() const { return ros_time_; }

  // Says that everything was reset. For a while messages from before may still be under way.
  void startLeftoverWindow(SteadyTime now);
  // In that window, what is stamped ahead of ROS time is from before.
  bool isLeftover(const ros::Time& stamp, SteadyTime now) const;

  // A cycle begins: the heartbeat is put off.
  void startCycle(SteadyTime now);

  bool mustBeat(SteadyTime now) const { return now >= heartbeat_due_; }
  // A heartbeat begins; the next one is due a second later.
  void startHeartbeat(SteadyTime now);

  SteadyTime heartbeatDue() const { return heartbeat_due_; }
  // When to go on after a failure at `now`: not before the cause may have gone.
  SteadyTime retryTime(SteadyTime now) const;

 private:
  const std::chrono::steady_clock::duration silence_;
  ros::Time ros_time_;
  SteadyTime heartbeat_due_, window_end_;
};

}  // namespace deformable_contact_monitor
