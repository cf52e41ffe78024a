// Differences of ROS times that no stamp, however senseless, can break.
#pragma once

#include <ros/time.h>

#include <algorithm>
#include <cstdint>

namespace deformable_contact_monitor {

// a - b [ns]. ros::Duration throws beyond 68 years, and any publisher may send such stamps.
inline std::int64_t nanosecondsBetween(const ros::Time& a, const ros::Time& b) {
  return static_cast<std::int64_t>(a.toNSec()) - static_cast<std::int64_t>(b.toNSec());
}

inline double secondsBetween(const ros::Time& a, const ros::Time& b) {
  return 1e-9 * static_cast<double>(nanosecondsBetween(a, b));
}

// Cut off where ros::Duration ends.
inline ros::Duration toDuration(double seconds) {
  constexpr double kLimit = 2147483646;
  return ros::Duration(std::clamp(seconds, -kLimit, kLimit));
}

}  // namespace deformable_contact_monitor
