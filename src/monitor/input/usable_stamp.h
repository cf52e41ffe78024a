// Decides which stamps are accepted: those of meshes and of moving transforms.
#pragma once

#include <ros/time.h>

#include <chrono>

#include "core/steady_time.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {

// How far ahead of the clock a stamp may be [s]. Clocks of machines differ a little, and some
// publishers predict. What is stamped further ahead comes from a clock that is wrong: it would tell
// where things were as if they were there now.
constexpr double kMaxAheadS = 1;

// How much the clocks of two machines usually differ [s].
constexpr double kClockToleranceS = 0.1;

// Returns whether a transform with that stamp may enter the buffer at `now` (zero: no clock yet).
inline bool isUsableStamp(const ros::Time& stamp, const ros::Time& now) {
  return now.isZero() || secondsBetween(stamp, now) <= kMaxAheadS;
}

// Recognises messages from before a jump of the clock. The window is short, because a publisher's
// own clock may be ahead, too. One thread at a time.
class LeftoverWindow {
 public:
  // Notes that everything was reset. For half a second, messages from before may still arrive.
  void open(SteadyTime steady_now) { end_ = steady_now + std::chrono::milliseconds(500); }
  // Returns whether a message with that stamp is from before the reset: within that half second,
  // and stamped ahead of ROS time.
  bool isLeftover(const ros::Time& stamp, const ros::Time& now, SteadyTime steady_now) const {
    return steady_now < end_ && secondsBetween(stamp, now) > kClockToleranceS;
  }

 private:
  SteadyTime end_;
};

}  // namespace deformable_contact_monitor
