// Decides which stamps are accepted: those of meshes and of moving transforms.
#pragma once

#include <ros/time.h>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {

// How far ahead of the clock a stamp may be [s]. Clocks of machines differ a little, and some
// publishers predict. What is stamped further ahead comes from a clock that is wrong: it would tell
// where things were as if they were there now.
constexpr double kMaxAheadS = 1;

// Returns whether a transform with that stamp may enter the buffer at `now` (zero: no clock yet).
inline bool isUsableStamp(const ros::Time& stamp, const ros::Time& now) {
  return now.isZero() || secondsBetween(stamp, now) <= kMaxAheadS;
}

}  // namespace deformable_contact_monitor
