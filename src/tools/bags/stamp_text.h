// Stamps as text, for tables and messages.
#pragma once

#include <ros/time.h>

#include <cstdio>
#include <string>

namespace deformable_contact_monitor {

// Seconds with nine decimals.
inline std::string stampText(const ros::Time& stamp) {
  char text[32];
  std::snprintf(text, sizeof text, "%u.%09u", stamp.sec, stamp.nsec);
  return text;
}

}  // namespace deformable_contact_monitor
