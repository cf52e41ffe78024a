// Decides which stamps of moving transforms are accepted.
#pragma once

#include <ros/time.h>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {

// Returns whether a transform with that stamp may enter the buffer at `now` (zero: no clock yet).
// tf2 keeps transforms within some seconds of the newest one, so a stamp from far ahead of the
// clock would exclude all that follow.
inline bool isUsableStamp(const ros::Time& stamp, const ros::Time& now) {
  constexpr double kMaxAheadS = 5;  // tf2 keeps 10 s
  return now.isZero() || secondsBetween(stamp, now) <= kMaxAheadS;
}

}  // namespace deformable_contact_monitor
