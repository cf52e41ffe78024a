// Times of the steady clock, which never jumps, and conversions from and to seconds.
#pragma once

#include <chrono>

namespace deformable_contact_monitor {

using SteadyTime = std::chrono::steady_clock::time_point;

inline SteadyTime::duration fromSeconds(double s) {
  return std::chrono::duration_cast<SteadyTime::duration>(std::chrono::duration<double>(s));
}

inline double toSeconds(SteadyTime::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

// Returns the time from then until now [s].
inline double secondsSince(SteadyTime then) {
  return toSeconds(std::chrono::steady_clock::now() - then);
}

}  // namespace deformable_contact_monitor
