// Finds where the clock of a recording went back, as when a simulator starts anew.
#include "tools/bags/time_jumps.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kOrderS = 0.2;         // stamps of one source may be out of order by this [s]
constexpr double kLateS = 2;            // a message that is later than this is odd [s]
constexpr double kLongestPauseS = 600;  // of a source [s]
constexpr double kUntilCertainS = 1;    // stamps are elsewhere for this long after a jump [s]
constexpr double kClocksDifferS = 5;    // stamps of one clock differ less when received [s]
constexpr double kRecentS = 5;          // messages are remembered for so long [s]
// After so many messages, or kUntilCertainS, a source that goes back once more has jumped twice.
constexpr std::size_t kFewest = 3;

}  // namespace

double TimeJumps::Source::backBy() const { return secondsBetween(newest, odd.stamp); }

// Returns the first stamp that does not fit, or the end if that is not remembered yet.
std::deque<TimeJumps::Message>::const_iterator TimeJumps::Source::firstOdd() const {
  return std::find_if(recent.begin(), recent.end(), [this](const Message& message) {
    return message.received > odd.received ||
           (message.received == odd.received && message.stamp == odd.stamp);
  });
}

// Unlike backBy(), this does not depend on how often the source sends.
double TimeJumps::Source::clockBackBy() const {
  const auto first = firstOdd();
  if (first == recent.begin()) return backBy();
  const Message& before = *std::prev(first);
  return secondsBetween(before.stamp, odd.stamp) + secondsBetween(odd.received, before.received);
}

// Returns whether this source went back by as much as another one, and shortly before it.
bool TimeJumps::Source::precedes(const Source& other) const {
  const double earlier_s = secondsBetween(other.odd.received, odd.received);
  return isBack() && earlier_s >= 0 && earlier_s < kOrderS &&
         std::abs(clockBackBy() - other.clockBackBy()) < kOrderS;
}

void TimeJumps::Source::beginAnew(const ros::Time& stamp) {
  newest = stamp;
  odd = last_odd = {};
  odd_count = 0;
  is_awaited = false;
}

void TimeJumps::Source::addOdd(const Message& message) {
  if (odd_count++ == 0) odd = message;
  last_odd = message;
}

// Begins anew after a jump. The clock may have gone back once more since, and then the stamps from
// there on are odd again.
void TimeJumps::Source::beginAfterJump() {
  const auto last = std::adjacent_find(
      firstOdd(), recent.cend(), [](const Message& before, const Message& after) {
        return secondsBetween(after.stamp, before.stamp) < -kOrderS;
      });
  if (last == recent.cend()) return beginAnew(last_odd.stamp);
  beginAnew(last->stamp);
  std::for_each(std::next(last), recent.cend(),
                [this](const Message& message) { addOdd(message); });
}

// Always keeps the last message of before that time, for sources that are slow.
void TimeJumps::Source::remember(const Message& message) {
  recent.push_back(message);
  while (recent.size() > 2 && secondsBetween(message.received, recent[1].received) > kRecentS) {
    recent.pop_front();
  }
}

// Returns whether the stamps advanced by as much as the time of receipt did.
bool TimeJumps::goesOn(const Message& before, const Message& after, double tolerance_s) {
  return std::abs(secondsBetween(after.stamp, before.stamp) -
                  secondsBetween(after.received, before.received)) < tolerance_s;
}

TimeJumps::Fit TimeJumps::look(const std::string& name, Kind kind, const ros::Time& stamp,
                               const ros::Time& received) {
  if (stamp.isZero()) return Fit::kOdd;
  Source& source = sources_[name];
  source.kind = kind;
  const Message message{stamp, received};
  Fit fit = Fit::kOdd;
  if (source.is_awaited && isLeftover(source, message)) {
    jumps_.back().later[name] = received + ros::Duration(0, 1);
  } else {
    if (source.newest.isZero() || source.is_awaited) source.beginAnew(stamp);
    fit = fitOf(name, &source, message);
  }
  source.remember(message);
  return fit;
}

TimeJumps::Fit TimeJumps::fitOf(const std::string& name, Source* source, const Message& message) {
  const double ahead_s = secondsBetween(message.stamp, source->newest);
  const bool is_back = source->isBack();
  if (ahead_s >= -kOrderS && ahead_s <= kLongestPauseS) {
    // Late messages are followed by one that has caught up.
    if (is_back && goesOn(source->last_odd, message, source->backBy() / 2) && jump(name)) {
      source->beginAnew(message.stamp);
      return Fit::kAnew;
    }
    source->beginAnew(std::max(source->newest, message.stamp));
    return Fit::kFits;
  }
  const bool falls =
      source->isOdd() && secondsBetween(message.stamp, source->last_odd.stamp) < -kOrderS;
  const bool is_certain = source->odd_count >= kFewest ||
                          secondsBetween(message.received, source->odd.received) >= kUntilCertainS;
  if (falls && is_back && is_certain && jump(name)) {
    return fitOf(name, source, message);
  }
  const bool is_other =
      source->isOdd() &&
      ((ahead_s < 0) != is_back || secondsBetween(message.stamp, source->odd.stamp) < -kLateS);
  if (is_other) source->beginAnew(source->newest);
  source->addOdd(message);
  if (secondsBetween(message.received, source->odd.received) >= kUntilCertainS) {
    if (ahead_s > 0) source->beginAnew(message.stamp);
    if (ahead_s > 0 || jump(name)) return Fit::kAnew;
  }
  return ahead_s < -kLateS || ahead_s > 0 ? Fit::kOdd : Fit::kFits;
}

// Returns whether a source goes on as before the last jump.
bool TimeJumps::isLeftover(const Source& source, const Message& message) const {
  const Jump& jump = jumps_.back();
  return secondsBetween(message.received, jump.received) < kLateS &&
         goesOn(source.recent.back(), message, secondsBetween(jump.from, jump.to) / 2);
}

// Returns whether another source of the same clock goes on since the stamps of this one went back.
// One that went back with it says nothing.
bool TimeJumps::isContradicted(const std::string& name) const {
  const Source& source = sources_.at(name);
  const ros::Time& since = source.odd.received;
  for (const auto& [other_name, other] : sources_) {
    if (other_name == name || other.recent.empty() || other.recent.back().received <= since ||
        other.precedes(source)) {
      continue;
    }
    const auto after =
        std::find_if(other.recent.begin(), other.recent.end(),
                     [&since](const Message& message) { return message.received >= since; });
    if (after == other.recent.begin()) continue;
    const Message& before = *std::prev(after);
    if (!goesOn(before, other.recent.back(), source.backBy() / 2)) continue;
    if (source.kind == Kind::kMesh && other.kind == Kind::kPose) return true;
    const double ahead_s =
        secondsBetween(before.stamp, source.newest) + secondsBetween(since, before.received);
    if (std::abs(ahead_s) < kClocksDifferS) return true;
  }
  return false;
}

// Notes that the clock went back, unless other sources contradict. All that went back did it at the
// same time, so the jump is where the first of them did.
bool TimeJumps::jump(const std::string& name) {
  if (isContradicted(name)) return false;
  const Source& source = sources_[name];
  Jump jump{source.odd.received, source.newest, source.odd.stamp};
  for (const auto& [other_name, other] : sources_) {
    const double earlier_s = secondsBetween(source.odd.received, other.odd.received);
    if (other.isBack() && earlier_s < kLateS && other.odd.received < jump.received) {
      jump = {other.odd.received, other.newest, other.odd.stamp};
    }
  }
  for (auto& [other_name, other] : sources_) {
    if (other.isBack()) {
      if (other.odd.received > jump.received) jump.later[other_name] = other.odd.received;
      other.beginAfterJump();
    } else if (!other.recent.empty()) {
      other.beginAnew(other.recent.back().stamp);
      other.is_awaited = other.recent.back().received <= jump.received;
    }
  }
  jumps_.push_back(std::move(jump));
  return true;
}

// Two messages that rise are no late ones.
void TimeJumps::finish() {
  for (const auto& [name, source] : sources_) {
    if (source.isBack() && source.odd.stamp < source.last_odd.stamp && jump(name)) return;
  }
}

std::size_t TimeJumps::partAt(const ros::Time& received) const {
  const auto later = std::find_if(jumps_.begin(), jumps_.end(),
                                  [&](const Jump& jump) { return received < jump.received; });
  return static_cast<std::size_t>(later - jumps_.begin());
}

std::size_t TimeJumps::partOf(const std::string& source, const ros::Time& received) const {
  std::size_t part = partAt(received);
  for (; part > 0; --part) {
    const Jump& jump = jumps_[part - 1];
    const auto later = jump.later.find(source);
    if (later == jump.later.end() || later->second <= received) break;
  }
  return part;
}

}  // namespace deformable_contact_monitor
