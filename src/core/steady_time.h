// Times of the steady clock, which never jumps, and conversions from and to seconds.
#pragma once

#include <algorithm>
#include <chrono>

namespace deformable_contact_monitor {

using SteadyTime = std::chrono::steady_clock::time_point;

// Longer times become some hundred years, so that their sum with a time of the clock does not
// overflow: now + fromSeconds(infinity) never comes. NaN counts as a time that is long past.
inline SteadyTime::duration fromSeconds(double s) {
  constexpr double kMostS = 3e9;
  s = s > -kMostS ? std::min(s, kMostS) : -kMostS;
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
