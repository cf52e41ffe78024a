// The time rules of the detection loop: waits, heartbeats, jumps of ROS time, and a cycle's time
// budget.
#include "monitor/cycle/cycle_clock.h"

#include <algorithm>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

using Duration = std::chrono::steady_clock::duration;

constexpr std::chrono::seconds kHeartbeatPeriod(1);
constexpr std::chrono::milliseconds kRosTimePeriod(10);  // between two looks at ROS time

// Returns how much time has passed since the wait began, by ROS time.
Duration passedOfRosTime(const Wait& wait, const ros::Time& ros_time) {
  return std::chrono::nanoseconds(nanosecondsBetween(ros_time, wait.ros_start));
}

}  // namespace

// Both clocks must have passed the length: transforms that are on their way take real time, also
// where ROS time runs fast.
bool Wait::isOver(SteadyTime now, const ros::Time& ros_time) const {
  const Duration steady = now - start;
  return steady >= most || (steady >= length && passedOfRosTime(*this, ros_time) >= length);
}

SteadyTime::duration Wait::passed(SteadyTime now, const ros::Time& ros_time) const {
  const Duration steady = now - start;
  if (most == length) return steady;
  return std::clamp(passedOfRosTime(*this, ros_time), Duration(0), steady);
}

SteadyTime Wait::nextLook(SteadyTime now) const {
  return std::min(start + most, std::max(start + length, now + kRosTimePeriod));
}

// After a cycle, silence has no meaning until the mesh of that cycle is too old.
CycleClock::CycleClock(double max_mesh_age_s, double budget_s, SteadyTime start, bool is_simulated)
    : silence_s_(std::max(toSeconds(kHeartbeatPeriod), max_mesh_age_s)),
      budget_s_(budget_s),
      is_simulated_(is_simulated) {
  startHeartbeat(start);
}

Wait CycleClock::startWait(double length_s, SteadyTime now) const {
  const Duration length = fromSeconds(length_s);
  return {now, ros_time_, length, is_simulated_ ? std::max<Duration>(kMostWait, length) : length};
}

double CycleClock::update(const ros::Time& now) {
  const double back_s = backS(now);
  ros_time_ = now;
  return back_s;
}

double CycleClock::backS(const ros::Time& now) const {
  const double back_s = secondsBetween(ros_time_, now);
  return back_s > kClockToleranceS ? back_s : 0;
}

void CycleClock::startCycle(SteadyTime now) { heartbeat_ = startWait(silence_s_, now); }

void CycleClock::startHeartbeat(SteadyTime now) {
  heartbeat_ = {now, ros_time_, kHeartbeatPeriod, kHeartbeatPeriod};
}

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
