// Finds where the clock of a recording went back, as when a simulator starts anew.
#include "tools/bags/time_jumps.h"

#include <algorithm>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kLateS = 2;            // a message may be this late without any jump [s]
constexpr double kLongestPauseS = 600;  // of a source [s]
constexpr double kUntilCertainS = 1;    // stamps are elsewhere for this long after a jump [s]
constexpr double kClocksDifferS = 1;    // the clocks of two sources may differ by this [s]

}  // namespace

TimeJumps::Fit TimeJumps::look(const std::string& name, const ros::Time& stamp,
                               const ros::Time& received) {
  if (stamp.isZero()) return Fit::kOdd;
  Source& source = sources_[name];
  if (source.newest.isZero()) source.newest = stamp;
  const double ahead_s = secondsBetween(stamp, source.newest);
  if (ahead_s >= -kLateS && ahead_s <= kLongestPauseS) {
    source.newest = std::max(source.newest, stamp);
    source.odd = ros::Time();
    return Fit::kFits;
  }
  const bool goes_on = !source.odd.isZero() && secondsBetween(stamp, source.odd) >= -kLateS &&
                       (source.odd < source.newest) == (stamp < source.newest);
  if (!goes_on) {
    source.odd = stamp;
    source.odd_received = received;
    return Fit::kOdd;
  }
  if (secondsBetween(received, source.odd_received) < kUntilCertainS) return Fit::kOdd;
  if (ahead_s < 0) {
    add(source);
    sources_.clear();
    sources_[name].newest = stamp;
  } else {
    source = {stamp, ros::Time(), ros::Time()};
  }
  return Fit::kAnew;
}

// All sources that went back did it at the same time. So the jump is where the first of them did.
void TimeJumps::add(const Source& source) {
  Jump jump{source.odd_received, source.newest, source.odd};
  for (const auto& [name, other] : sources_) {
    const double earlier_s = secondsBetween(source.odd_received, other.odd_received);
    if (!other.odd.isZero() && other.odd < other.newest && earlier_s < kLateS &&
        other.odd_received < jump.received) {
      jump = {other.odd_received, other.newest, other.odd};
    }
  }
  jumps_.push_back(jump);
}

std::size_t TimeJumps::partAt(const ros::Time& received) const {
  const auto later = std::find_if(jumps_.begin(), jumps_.end(),
                                  [&](const Jump& jump) { return received < jump.received; });
  return static_cast<std::size_t>(later - jumps_.begin());
}

bool TimeJumps::isLeftover(const ros::Time& stamp, const ros::Time& received) const {
  const std::size_t part = partAt(received);
  if (part == 0) return false;
  const Jump& jump = jumps_[part - 1];
  return secondsBetween(received, jump.received) < kLateS &&
         secondsBetween(stamp, jump.from) > -kClocksDifferS;
}

}  // namespace deformable_contact_monitor
