// Reads ~contact_states safely: a state that is unknown, too old or missing never counts as free.
//
// A program stores each message in a ContactReader, and asks it whether a body may move, or how far
// off, where and in which direction its nearest neighbour is. contact_reader.py of the Python
// package behaves alike; one table of test cases checks both.
#pragma once

#if __cplusplus < 201703L
#error "deformable_contact_monitor needs C++17: set(CMAKE_CXX_STANDARD 17)"
#endif

#include <deformable_contact_monitor/ContactState.h>
#include <deformable_contact_monitor/ContactStates.h>
#include <geometry_msgs/Point32.h>
#include <ros/time.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "reader/monitor_margins.h"

namespace deformable_contact_monitor {

// The conditions under which a body may move.
struct ReaderRules {
  // How long a state is valid after its own stamp [s], > 0. If no message arrives for so long,
  // nothing is known. Choose more than the period of the slowest mesh. Choose more than 1 s if
  // every pair may be ALLOWED, because the monitor then publishes only once a second.
  double max_age_s = 0.5;
  // A NEAR pair lets its bodies move if its certain distance is larger than this [m], >= 0;
  // infinity: a NEAR pair never does.
  double clearance_m = std::numeric_limits<double>::infinity();
  // True: a body that is in no state may move, if the message has states and the monitor knows the
  // robot's links. But a part ("cloth:hem") may not if its body is in some state, nor may a body
  // without a name. False: nothing is known of such a body.
  bool unlisted_may_move = false;
};

// Says whether a body may move, and if not, why.
struct MoveAnswer {
  bool yes = false;
  std::string because;  // why not; empty: yes

  explicit operator bool() const { return yes; }
};

// Says how far the nearest body is and where, or why that is not known.
struct NearestAnswer {
  bool is_known = false;
  std::string because;  // why it is not known; empty: it is
  // A distance that is certain [m], >= 0. 0 if the two touch, or if anything is not known; infinity
  // if nothing is within the monitor's margins.
  double distance_m = 0;
  // The body that was asked about (one of a pair if that was "*") and the nearest one; empty if
  // nothing is known or within the margins.
  std::string body, other;
  // Whether the points are known, which they are of NEAR and CONTACT. In the frame of the message
  // [m]: the nearest points of the two, or one point in the contact, twice.
  bool has_points = false;
  geometry_msgs::Point32 point, other_point;
  // Unit vector from `body` to `other`. In CONTACT it is zero without the monitor's
  // contact_geometry; with it, it is that of the deepest pair, and may turn round between cycles.
  geometry_msgs::Point32 normal;

  // As nearest() returned up to version 0.2.
  operator double() const { return distance_m; }  // NOLINT(google-explicit-constructor): as then
};

// Returns a distance [m], >= 0, below which the pair certainly is not. Returns 0 if the pair
// touches or nothing is known; infinity if it is ALLOWED, or NONE without a distance, because then
// nothing is within the monitor's margin. `tolerance_m` is that of the message. A malformed message
// adds no distance: never more than min_separation is returned, and 0 if `tolerance_m` is NaN.
inline double certainDistance(const ContactState& state, double tolerance_m) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double separation = state.min_separation;
  const double low = state.distance_low;
  if (state.state == ContactState::ALLOWED) return kInfinity;
  if (state.state != ContactState::NONE && state.state != ContactState::NEAR) return 0;
  if (std::isnan(separation)) return 0;
  if (state.state == ContactState::NEAR && std::isinf(separation)) return 0;
  if (low > 0 && std::isfinite(low)) return std::max(0.0, std::min(low, separation));
  // If the tolerance is NaN, the inner call returns NaN and the outer one 0. Both depend on the
  // order of their arguments.
  return std::max(0.0, separation - std::max(tolerance_m, 0.0));
}

// Keeps the newest states and answers questions about them. A body is named as in the monitor's
// output (a link or an object); "*" means all bodies, thus every pair. All times are ROS times; the
// caller passes the present one. Not safe for use by several threads.
class ContactReader {
 public:
  // The clocks of this process and of the monitor may differ by this much [s]. A state that is
  // stamped farther ahead counts as unknown.
  static constexpr double kClockSlackS = 0.1;

  // Throws std::invalid_argument if a rule is out of range.
  explicit ContactReader(const ReaderRules& rules = ReaderRules()) : rules_(rules) {
    if (!(rules.max_age_s > 0)) throw std::invalid_argument("max_age_s must be above 0");
    if (!(rules.clearance_m >= 0)) throw std::invalid_argument("clearance_m must not be below 0");
  }

  // Takes a message that arrived at `now`. An older message than the stored one (a lower cycle, or
  // an older stamp of the same cycle) is ignored, unless ROS time was reset or the monitor was
  // restarted. After one whose stamp is zero, nothing is known: its monitor has no clock.
  void store(const ContactStates& states, const ros::Time& now) {
    if (is_there_ && (now < received_ || !went_back_.empty())) forget("ROS time went back");
    if (is_there_ && seconds(newest_.header.stamp, now) <= kClockSlackS && isOlder(states)) return;
    const bool goes_on = is_there_ && states.cycle >= newest_.cycle;
    latest_stamp_ = goes_on ? std::max(latest_stamp_, states.header.stamp) : states.header.stamp;
    newest_ = states;
    received_ = now;
    is_there_ = true;
  }

  // Discards the states. Until the next message, every answer is no, because of `because`.
  void forget(const std::string& because) {
    is_there_ = false;
    went_back_.clear();
    newest_ = ContactStates();
    nothing_because_ = because;
  }

  // Returns yes only if the body is listed and each of its pairs is known, fresh, and NONE,
  // ALLOWED, or NEAR with a certain distance above clearance_m. Otherwise returns no and names the
  // first pair that forbids it.
  MoveAnswer mayMove(const std::string& body, const ros::Time& now) const {
    const std::string because =
        firstReason(body, now, [this](const ContactState& state) { return obstacle(state); });
    return {because.empty(), because};
  }

  // Returns the nearest of the body's pairs, by certainDistance(); of several at the same distance,
  // the first. Its distance_m may set a speed: it is 0 if one of the pairs is not known.
  NearestAnswer nearest(const std::string& body, const ros::Time& now) const {
    NearestAnswer answer;
    answer.because = whyUnknown(body, now);
    answer.is_known = answer.because.empty();
    if (!answer.is_known) return answer;
    const ContactState* const state = nearestState(body);
    answer.distance_m = std::numeric_limits<double>::infinity();
    if (state == nullptr) return answer;
    const bool is_a = body == "*" || isOf(state->body_a, body);
    answer.distance_m = certainDistance(*state, newest_.tolerance);
    answer.body = is_a ? state->body_a : state->body_b;
    answer.other = is_a ? state->body_b : state->body_a;
    answer.has_points = state->state == ContactState::NEAR || state->state == ContactState::CONTACT;
    answer.point = is_a ? state->point_a : state->point_b;
    answer.other_point = is_a ? state->point_b : state->point_a;
    answer.normal = state->normal;
    if (!is_a) {
      answer.normal.x = -answer.normal.x;
      answer.normal.y = -answer.normal.y;
      answer.normal.z = -answer.normal.z;
    }
    return answer;
  }

  // Returns nearest() in words: "0.1250 m, hand and cloth", "hand and cloth: CONTACT", "beyond the
  // margin of 0.05 m" if no pair has a distance, or why nothing is known. `margins` are the
  // monitor's; nothing: not known.
  std::string nearestText(const std::string& body, const ros::Time& now,
                          const std::optional<MonitorMargins>& margins = std::nullopt) const {
    std::string because = whyUnknown(body, now);
    if (!because.empty()) return because;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (const ContactState* const state = nearestState(body)) {
      const std::string pair = state->body_a + " and " + state->body_b;
      const std::string touching = nameOfContact(*state);
      if (!touching.empty()) return pair + ": " + touching;
      return text("%.4f m, ", certainDistance(*state, newest_.tolerance)) + pair;
    }
    double margin_m = kInfinity;
    for (const ContactState& state : newest_.states) {
      if (state.state != ContactState::NONE || !concerns(state, body)) continue;
      margin_m = std::min(margin_m, margins ? margins->of(state) : 0);
    }
    if (margin_m == kInfinity) return "no pair that matters";  // none, or all are ALLOWED
    return margins ? text("beyond the margin of %g m", margin_m) : "beyond the monitor's margin";
  }

  // Returns the body's pairs that are known to touch, or to have touched since their last cycle. An
  // empty list does not mean that the body may move: ask mayMove() for that.
  std::vector<ContactState> contacts(const std::string& body, const ros::Time& now) const {
    std::vector<ContactState> touching;
    if (!silence(now).empty()) return touching;
    for (const ContactState& state : newest_.states) {
      const bool touches =
          state.state == ContactState::CONTACT || state.state == ContactState::PASSED;
      if (touches && concerns(state, body) && doubt(state, now).empty()) touching.push_back(state);
    }
    return touching;
  }

  // Returns the last stored message, which may hold old and unknown states; empty before the first
  // message.
  const ContactStates& newest() const { return newest_; }

  // Returns whether the state is about that body, or about a part of it ("cloth:hem" is one of
  // "cloth"); "*" matches every state.
  static bool concerns(const ContactState& state, const std::string& body) {
    return body == "*" || isOf(state.body_a, body) || isOf(state.body_b, body);
  }

  // Returns whether the name is that of the body or of a part of it.
  static bool isOf(const std::string& name, const std::string& body) {
    return name.compare(0, body.size(), body) == 0 &&
           (name.size() == body.size() || name[body.size()] == ':');
  }

 private:
  static constexpr std::size_t kMostNames = 8;

  // Returns a - b [s]. ros::Duration would throw if they are more than 68 years apart.
  static double seconds(const ros::Time& a, const ros::Time& b) {
    return static_cast<double>(static_cast<std::int64_t>(a.toNSec()) -
                               static_cast<std::int64_t>(b.toNSec())) /
           1e9;
  }

  static std::string text(const char* format, double value) {
    char buffer[400];
    std::snprintf(buffer, sizeof buffer, format, value);
    return buffer;
  }

  // Returns whether a message is older than the stored one. A monitor that was restarted begins at
  // cycle 0 again, but its stamps are newer than all before.
  bool isOlder(const ContactStates& states) const {
    if (states.header.stamp.isZero()) return false;
    if (states.cycle == newest_.cycle) return states.header.stamp < newest_.header.stamp;
    return states.cycle < newest_.cycle && states.header.stamp <= latest_stamp_;
  }

  // Returns why nothing at all is known; empty if something is.
  std::string silence(const ros::Time& now) const {
    if (now.isZero()) return "ROS time is zero";
    if (!is_there_) return nothing_because_;
    if (newest_.header.stamp.isZero()) return "the monitor has no clock: its stamp is zero";
    const double silent_s = seconds(now, received_);
    // Once it went back, it will come to the old times again, and the states belong to the first.
    if (silent_s < -kClockSlackS && went_back_.empty()) {
      went_back_ = text("ROS time went back by %.3f s", -silent_s);
    }
    if (!went_back_.empty()) return went_back_;
    return silent_s > rules_.max_age_s ? text("no states came for %.3f s", silent_s) : "";
  }

  // Returns why the state is not known; empty if it is.
  std::string doubt(const ContactState& state, const ros::Time& now) const {
    if (state.state == ContactState::UNKNOWN) return "UNKNOWN: " + state.reason;
    if (state.state > ContactState::PASSED)
      return text("state %.0f is not known here", state.state);
    const double age_s = seconds(now, state.stamp);
    if (age_s > rules_.max_age_s) return text("its state is %.3f s old", age_s);
    if (age_s < -kClockSlackS) return text("its state is stamped %.3f s ahead", -age_s);
    const bool is_apart = state.state == ContactState::NONE || state.state == ContactState::NEAR;
    const bool is_number = state.state == ContactState::NEAR ? std::isfinite(state.min_separation)
                                                             : !std::isnan(state.min_separation);
    if (is_apart && !is_number) return "its distance is no number";
    const bool is_below_0 = state.state == ContactState::NONE && state.min_separation < 0;
    return is_below_0 ? "its distance is below 0" : "";
  }

  // Returns "CONTACT" or "PASSED" if the state is one of these; else empty.
  static std::string nameOfContact(const ContactState& state) {
    if (state.state == ContactState::CONTACT) return "CONTACT";
    return state.state == ContactState::PASSED ? "PASSED" : "";
  }

  // Returns the first reason that `question` has against one of the body's pairs, or why something
  // about the body is not known; empty if there is no reason.
  template <class Question>
  std::string firstReason(const std::string& body, const ros::Time& now,
                          const Question& question) const {
    std::string because = silence(now);
    if (!because.empty()) return because;
    bool is_listed = false;
    for (const ContactState& state : newest_.states) {
      if (!concerns(state, body)) continue;
      is_listed = true;
      because = doubt(state, now);
      if (because.empty()) because = question(state);
      if (!because.empty()) return state.body_a + " and " + state.body_b + ": " + because;
    }
    return is_listed || unlistedMayMove(body) ? "" : missing(body);
  }

  // Returns whether a body that is in no state may move. An empty list says nothing, and before the
  // monitor knows the robot's links, it has a body "robot" in their place, which is UNKNOWN. A part
  // that is not listed may be what touches in the states of its body.
  bool unlistedMayMove(const std::string& body) const {
    const std::string whole = body.substr(0, body.find(':'));
    if (!rules_.unlisted_may_move || whole.empty() || whole == "*") return false;
    const auto forbids = [&](const ContactState& state) {
      return (state.state == ContactState::UNKNOWN && concerns(state, "robot")) ||
             concerns(state, whole);
    };
    return !newest_.states.empty() &&
           std::none_of(newest_.states.begin(), newest_.states.end(), forbids);
  }

  // Returns why something about the body is not known; empty if all is.
  std::string whyUnknown(const std::string& body, const ros::Time& now) const {
    return firstReason(body, now, [](const ContactState&) { return std::string(); });
  }

  // Returns the first of the body's states with the least certain distance; null if none has one.
  const ContactState* nearestState(const std::string& body) const {
    const ContactState* nearest = nullptr;
    double least_m = std::numeric_limits<double>::infinity();
    for (const ContactState& state : newest_.states) {
      if (!concerns(state, body)) continue;
      const double distance_m = certainDistance(state, newest_.tolerance);
      if (distance_m < least_m) nearest = &state;
      least_m = std::min(least_m, distance_m);
    }
    return nearest;
  }

  // Returns what is said of a body without states. Names the first bodies that have some, because
  // most such names are misspelled.
  std::string missing(const std::string& body) const {
    if (body == "*") return "no pair is monitored";
    std::set<std::string> names;
    for (const ContactState& state : newest_.states) names.insert({state.body_a, state.body_b});
    std::string listed;
    std::size_t count = 0;
    for (const std::string& name : names) {
      if (++count > kMostNames) break;
      listed += (count == 1 ? "; there are " : ", ") + name;
    }
    return (body.empty() ? "''" : body) + " is in no state" + listed +
           (names.size() > kMostNames ? ", ..." : "");
  }

  // Returns why a known state forbids its bodies to move; empty if it does not.
  std::string obstacle(const ContactState& state) const {
    std::string touching = nameOfContact(state);
    if (!touching.empty()) return touching;
    if (state.state != ContactState::NEAR) return "";
    const double distance_m = certainDistance(state, newest_.tolerance);
    return distance_m > rules_.clearance_m ? "" : text("NEAR, %.4f m", distance_m);
  }

  ReaderRules rules_;
  bool is_there_ = false;
  ContactStates newest_;
  ros::Time latest_stamp_;  // of all messages of this run of the monitor
  ros::Time received_;      // ROS time at which newest_ came
  std::string nothing_because_ = "no states came yet";
  mutable std::string went_back_;  // why the stored states do not count any more; empty: they do
};

}  // namespace deformable_contact_monitor
