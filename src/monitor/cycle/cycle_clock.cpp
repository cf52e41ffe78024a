// The time rules of the detection loop: heartbeats, jumps of ROS time, and a cycle's time budget.
#include "monitor/cycle/cycle_clock.h"

#include <algorithm>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

using Duration = std::chrono::steady_clock::duration;

constexpr std::chrono::seconds kHeartbeatPeriod(1);
constexpr std::chrono::milliseconds kLeftoverWindow(500);
constexpr double kClockToleranceS = 0.1;  // the clocks of two machines differ a little

}  // namespace

// After a cycle, silence has no meaning until the mesh of that cycle is too old.
CycleClock::CycleClock(double max_mesh_age_s, double budget_s, SteadyTime start)
    : silence_(std::max<Duration>(kHeartbeatPeriod, fromSeconds(max_mesh_age_s))),
      budget_s_(budget_s),
      heartbeat_due_(start + kHeartbeatPeriod) {}

double CycleClock::update(const ros::Time& now) {
  const double back_s = backS(now);
  ros_time_ = now;
  return back_s;
}

double CycleClock::backS(const ros::Time& now) const {
  const double back_s = secondsBetween(ros_time_, now);
  return back_s > kClockToleranceS ? back_s : 0;
}

void CycleClock::startLeftoverWindow(SteadyTime now) { window_end_ = now + kLeftoverWindow; }

// After a clock went back, messages from before are stamped ahead of it. The window is short, as a
// publisher's own clock may be ahead as well.
bool CycleClock::isLeftover(const ros::Time& stamp, SteadyTime now) const {
  return now < window_end_ && secondsBetween(stamp, ros_time_) > kClockToleranceS;
}

void CycleClock::startCycle(SteadyTime now) { heartbeat_due_ = now + silence_; }

void CycleClock::startHeartbeat(SteadyTime now) { heartbeat_due_ = now + kHeartbeatPeriod; }

SteadyTime CycleClock::retryTime(SteadyTime now) const { return now + kHeartbeatPeriod; }

// Half of the budget always belongs to the detection, however long publishing took lately.
SteadyTime CycleClock::deadline(SteadyTime arrival) const {
  if (budget_s_ == 0) return SteadyTime::max();
  return std::max(publishing_.earlier(arrival + fromSeconds(budget_s_)),
                  arrival + fromSeconds(budget_s_ / 2));
}

void CycleClock::recordCycle(SteadyTime deadline, SteadyTime detected, SteadyTime published) {
  publishing_.took(std::max(SteadyTime::duration(0), published - std::min(deadline, detected)));
}

}  // namespace deformable_contact_monitor
