// When there is to be a heartbeat, and when time has jumped.
#include "monitor/cycle/cycle_clock.h"

#include <algorithm>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

using Duration = std::chrono::steady_clock::duration;

constexpr std::chrono::seconds kHeartbeatPeriod(1);
constexpr std::chrono::milliseconds kLeftoverWindow(500);
constexpr double kClockToleranceS = 0.1;  // clocks of two machines differ a little

}  // namespace

// Silence after a cycle is no news until its mesh is too old.
CycleClock::CycleClock(double max_mesh_age_s, SteadyTime start)
    : silence_(std::max<Duration>(kHeartbeatPeriod, fromSeconds(max_mesh_age_s))),
      heartbeat_due_(start + kHeartbeatPeriod) {}

double CycleClock::update(const ros::Time& now) {
  const double back_s = secondsBetween(ros_time_, now);
  ros_time_ = now;
  return back_s > kClockToleranceS ? back_s : 0;
}

void CycleClock::startLeftoverWindow(SteadyTime now) { window_end_ = now + kLeftoverWindow; }

bool CycleClock::isLeftover(const ros::Time& stamp, SteadyTime now) const {
  return now < window_end_ && secondsBetween(stamp, ros_time_) > kClockToleranceS;
}

void CycleClock::startCycle(SteadyTime now) { heartbeat_due_ = now + silence_; }

void CycleClock::startHeartbeat(SteadyTime now) { heartbeat_due_ = now + kHeartbeatPeriod; }

SteadyTime CycleClock::retryTime(SteadyTime now) const { return now + kHeartbeatPeriod; }

}  // namespace deformable_contact_monitor
