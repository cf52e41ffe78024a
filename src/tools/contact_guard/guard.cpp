// Decides the speed scale and the stop (see guard.h for the rules). ContactReader answers whether
// each link may move; this file adds the watch of both clocks, the latch, and the scale.
#include "tools/contact_guard/guard.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// Makes ContactReader answer "no" for a pair at stop_distance_m or nearer.
ReaderRules readerRules(const GuardParameters& parameters) {
  ReaderRules rules;
  rules.max_age_s = parameters.max_age_s;
  rules.clearance_m = parameters.stop_distance_m;
  return rules;
}

std::string seconds(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3f s", value);
  return text;
}

std::string metres(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%.4f m", value);
  return text;
}

}  // namespace

Guard::Guard(const GuardParameters& parameters, SteadyTime start)
    : parameters_(parameters),
      reader_(readerRules(parameters)),
      heard_(start),
      clock_moved_(start),
      latched_(parameters.latch) {}

// Returns whether the pair has one of the guard's links; with no links, every pair counts.
bool Guard::counts(const ContactState& state) const {
  const auto concerns = [&state](const std::string& link) {
    return ContactReader::concerns(state, link);
  };
  return parameters_.links.empty() ||
         std::any_of(parameters_.links.begin(), parameters_.links.end(), concerns);
}

// Follows the stored message rather than the given one, because the reader ignores a late one.
void Guard::store(const ContactStates& states, const ros::Time& now, SteadyTime steady_now) {
  watchClock(now, steady_now);
  reader_.store(states, now);
  heard_ = steady_now;
  const ContactStates& newest = reader_.newest();
  for (const ContactState& state : newest.states) {
    if (counts(state)) follow(state, newest.tolerance);
  }
}

// Updates whether a pair approaches or recedes. The direction turns only after the distance has
// changed by receding_m from its extreme, so that noise does not turn it. An UNKNOWN state changes
// nothing: the next known distance is compared with those before it.
void Guard::follow(const ContactState& state, double tolerance_m) {
  if (state.state == ContactState::UNKNOWN) return;
  const PairName name(state.body_a, state.body_b);
  const bool is_near = state.state == ContactState::NEAR || state.state == ContactState::CONTACT;
  if (!is_near || parameters_.receding_m == 0) {
    courses_.erase(name);
    return;
  }
  const double distance_m = certainDistance(state, tolerance_m);
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
  if (step_s < -ContactReader::kClockSlackS) {
    reader_.forget("ROS time went back by " + seconds(-step_s));
    courses_.clear();
  }
  ros_time_ = now;
}

// Returns the first reason to stop, or an empty text. The clock is checked first: while ROS time
// stands still, no state would ever become too old.
std::string Guard::causeOfStop(const ros::Time& now, SteadyTime steady_now) {
  watchClock(now, steady_now);
  const double still_s = toSeconds(steady_now - clock_moved_);
  if (still_s > parameters_.max_silence_s) {
    return "ROS time stands still for " + seconds(still_s);
  }
  const std::vector<std::string> all = {"*"};
  for (const std::string& body : parameters_.links.empty() ? all : parameters_.links) {
    const MoveAnswer answer = reader_.mayMove(body, now);
    if (!answer) return answer.because;
  }
  const double silent_s = toSeconds(steady_now - heard_);
  if (silent_s > parameters_.max_silence_s) {
    return "no states came for " + seconds(silent_s) + " of wall time";
  }
  return missingBody();
}

// Returns which required body is in no pair that counts; empty: each is in one.
std::string Guard::missingBody() const {
  const std::vector<ContactState>& states = reader_.newest().states;
  for (const std::string& body : parameters_.required_bodies) {
    const bool is_there = std::any_of(states.begin(), states.end(), [&](const ContactState& state) {
      return counts(state) && ContactReader::concerns(state, body);
    });
    if (!is_there) return "required " + body + " is in no state";
  }
  return "";
}

// Returns the scale when nothing stops the robot: the least over all pairs that do not recede.
GuardOutput Guard::slowed() const {
  GuardOutput output{false, 1, ""};
  const double range_m = parameters_.slow_distance_m - parameters_.stop_distance_m;
  for (const ContactState& state : reader_.newest().states) {
    if (!counts(state)) continue;
    const double distance_m = certainDistance(state, reader_.newest().tolerance);
    if (!(distance_m < parameters_.slow_distance_m)) continue;
    const auto course = courses_.find({state.body_a, state.body_b});
    if (course != courses_.end() && course->second.recedes) continue;
    const double share =
        range_m > 0 ? std::max(0.0, (distance_m - parameters_.stop_distance_m) / range_m) : 0;
    const double scale = parameters_.least_scale + (1 - parameters_.least_scale) * share;
    if (scale >= output.scale) continue;
    output.scale = scale;
    output.because = state.body_a + " and " + state.body_b + ": " + metres(distance_m);
  }
  return output;
}

// The latch keeps its first reason, which tells more than a later one.
GuardOutput Guard::decide(const ros::Time& now, SteadyTime steady_now) {
  const std::string cause = causeOfStop(now, steady_now);
  if (!cause.empty()) {
    if (parameters_.latch && !latched_) {
      latched_ = true;
      latched_because_ = cause;
    }
    return {true, 0, cause};
  }
  if (latched_) return {true, 0, "latched: " + latched_because_};
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
