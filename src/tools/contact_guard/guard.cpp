// Decides the speed scale and the stop (see guard.h for the rules). ContactReader answers whether
// each link may move; this file adds the watch of both clocks, the latch, and the scale.
#include "tools/contact_guard/guard.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "monitor/time_difference.h"
#include "tools/common/formatted.h"

namespace deformable_contact_monitor {
namespace {

// Makes ContactReader answer "no" for a pair at stop_distance_m or nearer.
ReaderRules readerRules(const GuardParameters& parameters) {
  ReaderRules rules;
  rules.max_age_s = parameters.max_age_s;
  rules.clearance_m = parameters.stop_distance_m;
  return rules;
}

std::string seconds(double value) { return formatted("%.3f s", value); }
std::string metres(double value) { return formatted("%.4f m", value); }
std::string speed(double value) { return formatted("%.3f m/s", value); }

}  // namespace

Guard::Guard(const GuardParameters& parameters, SteadyTime start)
    : parameters_(parameters),
      reader_(readerRules(parameters)),
      rivals_(parameters.monitor + "/contact_states"),
      heard_(start),
      clock_moved_(start),
      latched_(parameters.latch) {}

// Follows the stored message rather than the given one, because the reader ignores a late one. A
// latch looks at every message, since a cause may be over before the next output.
void Guard::store(const ContactStates& states, const std::string& publisher, const ros::Time& now,
                  SteadyTime steady_now) {
  watchClock(now, steady_now);
  heard_ = steady_now;
  const std::string problem = rivals_.look(publisher, steady_now);
  if (problem.empty()) {
    reader_.store(states, now);
  } else {
    forget(problem);
  }
  const ContactStates& newest = reader_.newest();
  for (const ContactState& state : newest.states) {
    if (counts(parameters_, state)) follow(state, newest.tolerance);
  }
  if (parameters_.latch) latch(causeOfStop(now, steady_now));
}

// Forgets the states and how distances changed. Until states are stored again, the guard stops
// because of `because`.
void Guard::forget(const std::string& because) {
  reader_.forget(because);
  courses_.clear();
  closing_.clear();
}

// Keeps the first cause, which tells more than a later one. An empty text changes nothing.
void Guard::latch(const std::string& cause) {
  if (!parameters_.latch || latched_ || cause.empty()) return;
  latched_ = true;
  latched_because_ = cause;
}

// Follows a pair's distance. After an UNKNOWN state the pair does not recede, because it may have
// turned meanwhile. Its closing speed is measured with the distances before.
void Guard::follow(const ContactState& state, double tolerance_m) {
  const PairName name(state.body_a, state.body_b);
  if (state.state == ContactState::UNKNOWN) {
    courses_.erase(name);
    return;
  }
  const bool is_near = state.state == ContactState::NEAR || state.state == ContactState::CONTACT;
  if (!is_near) {
    courses_.erase(name);
    closing_.erase(name);
    return;
  }
  const double distance_m = certainDistance(state, tolerance_m);
  if (parameters_.receding_m > 0) turn(name, distance_m);
  if (parameters_.time_to_contact_s > 0) {
    closing_[name].add(static_cast<std::int64_t>(state.stamp.toNSec()), distance_m,
                       parameters_.closing_window_s, parameters_.max_age_s);
  }
}

// Updates whether a pair approaches or recedes. The direction turns only after the distance has
// changed by receding_m from its extreme, so that noise does not turn it.
void Guard::turn(const PairName& name, double distance_m) {
  const auto [found, is_new] = courses_.emplace(name, Course{false, distance_m});
  Course& course = found->second;
  course.turn_m =
      course.recedes ? std::max(course.turn_m, distance_m) : std::min(course.turn_m, distance_m);
  if (std::abs(distance_m - course.turn_m) < parameters_.receding_m) return;
  course = {!course.recedes, distance_m};
}

// Notes when ROS time last changed. A clock that went back invalidates all stamps, so the guard
// forgets the states and stops until new ones arrive.
void Guard::watchClock(const ros::Time& now, SteadyTime steady_now) {
  const double step_s = secondsBetween(now, ros_time_);
  if (step_s != 0) clock_moved_ = steady_now;
  if (step_s < -ContactReader::kClockSlackS) forget("ROS time went back by " + seconds(-step_s));
  ros_time_ = now;
}

// Returns the first reason to stop, or an empty text. The clock is checked first: while ROS time
// stands still, no state would ever become too old.
std::string Guard::causeOfStop(const ros::Time& now, SteadyTime steady_now) {
  watchClock(now, steady_now);
  const double still_s = toSeconds(steady_now - clock_moved_);
  const double silent_s = toSeconds(steady_now - heard_);
  if (std::max(still_s, silent_s) > parameters_.max_silence_s) courses_.clear();
  if (still_s > parameters_.max_silence_s) {
    return "ROS time stands still for " + seconds(still_s);
  }
  std::string silence;
  if (silent_s > parameters_.max_silence_s) {
    silence = "no states came for " + seconds(silent_s) + " of wall time";
  }
  if (rivals_.areThere() && !silence.empty()) return silence;  // both have ended
  const std::vector<std::string> all = {"*"};
  for (const std::string& body : parameters_.links.empty() ? all : parameters_.links) {
    const MoveAnswer answer = reader_.mayMove(body, now);
    if (!answer) return answer.because;
  }
  return silence.empty() ? missingBody() : silence;
}

// Returns which required body is in no pair that counts; empty: each is in one.
std::string Guard::missingBody() const {
  const std::vector<ContactState>& states = reader_.newest().states;
  for (const std::string& body : parameters_.required_bodies) {
    const bool is_there = std::any_of(states.begin(), states.end(), [&](const ContactState& state) {
      return counts(parameters_, state) && ContactReader::concerns(state, body);
    });
    if (!is_there) return "required " + body + " is in no state";
  }
  return "";
}

// Returns the smaller one of the scales by distance and by time. A pair that certainly leaves slows
// nothing: its newest distance is the greatest. A pair that recedes is not slowed by its distance
// until it has turned back by receding_m.
Guard::PairScale Guard::scaleOf(const ContactState& state, double distance_m) const {
  const PairName name(state.body_a, state.body_b);
  const std::string pair = state.body_a + " and " + state.body_b + ": " + metres(distance_m);
  const auto motion = closing_.find(name);
  if (motion != closing_.end() && motion->second.isLeaving()) return {};
  const auto course = courses_.find(name);
  PairScale result;
  if (course == courses_.end() || !course->second.recedes) {
    result = {scaleByDistance(distance_m, parameters_), pair};
  }
  if (motion == closing_.end()) return result;
  const double mean = scales_.mean(motion->second.oldestNs(), motion->second.newestNs());
  const auto measured = motion->second.estimate();
  const double closing_mps = closingAtFullSpeed(measured, mean, parameters_);
  const double by_time = scaleByTime(distance_m, closing_mps, parameters_);
  if (by_time >= result.scale) return result;
  const std::string how = measured ? ", closing at " + speed(measured->mostMps())
                                   : ", its closing speed is not known yet";
  return {by_time, pair + how};
}

// Returns the output when nothing stops the robot: the least scale over all pairs.
GuardOutput Guard::slowed() const {
  GuardOutput output{false, 1, "", false, ""};
  double nearest_m = parameters_.warn_distance_m;
  for (const ContactState& state : reader_.newest().states) {
    if (!counts(parameters_, state)) continue;
    const double distance_m = certainDistance(state, reader_.newest().tolerance);
    if (!std::isfinite(distance_m)) continue;
    if (parameters_.warn_distance_m > 0 && distance_m <= nearest_m) {
      nearest_m = distance_m;
      output.warn = true;
      output.near = state.body_a + " and " + state.body_b + ": " + metres(distance_m);
    }
    const PairScale scale = scaleOf(state, distance_m);
    if (scale.scale >= output.scale) continue;
    output.scale = scale.scale;
    output.because = scale.because;
  }
  return output;
}

// Notes the output, because a closing speed that is measured later was scaled by it.
GuardOutput Guard::decide(const ros::Time& now, SteadyTime steady_now) {
  GuardOutput output = decideNow(now, steady_now);
  const auto now_ns = static_cast<std::int64_t>(now.toNSec());
  scales_.add(now_ns, output.scale);
  // No sample is older than max_age_s, and a state was not older than that when it arrived.
  scales_.dropBefore(now_ns - static_cast<std::int64_t>(2e9 * parameters_.max_age_s));
  return output;
}

GuardOutput Guard::decideNow(const ros::Time& now, SteadyTime steady_now) {
  const std::string cause = causeOfStop(now, steady_now);
  latch(cause);
  if (!cause.empty()) return {true, 0, cause, true, ""};
  if (latched_) return {true, 0, "latched: " + latched_because_, true, ""};
  return slowed();
}

// A reason that still holds keeps the latch.
std::string Guard::release(const ros::Time& now, SteadyTime steady_now) {
  std::string cause = causeOfStop(now, steady_now);
  if (cause.empty()) latched_ = false;
  return cause;
}

// Asks for all bodies ("*") if no links were named.
double Guard::nearest(const ros::Time& now) const {
  double least = std::numeric_limits<double>::infinity();
  if (parameters_.links.empty()) return reader_.nearest("*", now);
  for (const std::string& link : parameters_.links) {
    least = std::min<double>(least, reader_.nearest(link, now));
  }
  return least;
}

}  // namespace deformable_contact_monitor
