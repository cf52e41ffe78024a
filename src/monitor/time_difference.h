// Computes differences of ROS times without an exception, whatever the stamps are.
//
// ros::Duration throws beyond 68 years, and any publisher may send such stamps.
#pragma once

#include <ros/time.h>

#include <algorithm>
#include <cstdint>

namespace deformable_contact_monitor {

// Returns a - b [ns].
inline std::int64_t nanosecondsBetween(const ros::Time& a, const ros::Time& b) {
  return static_cast<std::int64_t>(a.toNSec()) - static_cast<std::int64_t>(b.toNSec());
}

// Returns a - b [s]. The division rounds once, so 600 000 000 ns give the double 0.6. Times 1e-9
// they do not.
inline double secondsBetween(const ros::Time& a, const ros::Time& b) {
  return static_cast<double>(nanosecondsBetween(a, b)) / 1e9;
}

// Returns the duration nearest to so many seconds that ros::Duration can hold.
inline ros::Duration toDuration(double seconds) {
  constexpr double kLimit = 2147483646;
  return ros::Duration(std::clamp(seconds, -kLimit, kLimit));
}

}  // namespace deformable_contact_monitor
