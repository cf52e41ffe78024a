// How each monitored pair of bodies stands, of when that is, and since when; begin and end of
// contact, debounced.
#include "monitor/state/contact_state_tracker.h"

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "monitor/messages/contact_messages.h"
#include "monitor/point32.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// Why nothing is known of the pair; empty if nothing speaks against it.
std::string bodyProblem(const CycleReport& report, const MonitoredPair& pair) {
  for (const BodyId id : {pair.a, pair.b}) {
    const BodyStatus& body = report.bodies.at(id);
    if (!body.unknown_because.empty()) return body.name + ": " + body.unknown_because;
  }
  return "";
}

// Nothing but the lack of a mesh of an object that has cycles of its own.
bool isPartnersProblem(const CycleReport& report, const MonitoredPair& pair) {
  const auto lacks = [&report](BodyId id) { return !report.bodies.at(id).unknown_because.empty(); };
  const auto is_partner = [&report](BodyId id) {
    return report.bodies.at(id).kind == BodyKind::kDeformable && !report.bodies.at(id).triggered;
  };
  return (!lacks(pair.a) || is_partner(pair.a)) && (!lacks(pair.b) || is_partner(pair.b));
}

bool isApart(const ContactState& state) {
  return state.state == ContactState::NONE || state.state == ContactState::NEAR;
}

// The pair touched since its last cycle.
void pass(const StepVerdict& step, ContactState* state) {
  state->state = ContactState::PASSED;
  state->pair_count = saturated(step.passed.count);
  state->min_separation = 0;
  state->centroid = toPoint32(step.passed.centroid());
  state->mean_normal = toPoint32(step.passed.meanNormal());
}

}  // namespace

ContactStateTracker::ContactStateTracker(const StateRules& rules) : rules_(rules) {
  if (rules.debounce_on_cycles < 1 || rules.debounce_off_cycles < 1) {
    throw std::invalid_argument("debounce cycles must be at least 1");
  }
}

void ContactStateTracker::update(const CycleReport& report) {
  const PairSummaries summaries(report);
  const StepVerdicts steps(report, rules_.tolerated_rejects);
  const std::lock_guard<std::mutex> lock(mutex_);
  frame_ = report.header.frame_id;
  cycle_ = report.cycle;
  listPairs(report);
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const MonitoredPair& pair = report.pairs[i];
    look(report, pair, summaries.of(pair.a, pair.b), steps, &tracks_[i]);
  }
}

void ContactStateTracker::listPairs(const CycleReport& report) {
  using Names = std::pair<std::string, std::string>;
  const auto names = [&report](const MonitoredPair& pair) {
    return Names(report.bodies.at(pair.a).name, report.bodies.at(pair.b).name);
  };
  const bool same =
      std::equal(tracks_.begin(), tracks_.end(), report.pairs.begin(), report.pairs.end(),
                 [&report](const Track& track, const MonitoredPair& pair) {
                   return track.state.body_a == report.bodies.at(pair.a).name &&
                          track.state.body_b == report.bodies.at(pair.b).name;
                 });
  if (same) return;
  std::map<Names, Track> before;
  for (Track& track : tracks_) {
    before.emplace(Names(track.state.body_a, track.state.body_b), std::move(track));
  }
  tracks_.clear();
  for (const MonitoredPair& pair : report.pairs) {
    const auto found = before.find(names(pair));
    if (found != before.end()) {
      tracks_.push_back(std::move(found->second));
      before.erase(found);
      continue;
    }
    Track track;
    std::tie(track.state.body_a, track.state.body_b) = names(pair);
    interrupt(ContactState::UNKNOWN, "not looked at yet", report.now, &track);
    track.state_before = ContactState::UNKNOWN;
    tracks_.push_back(std::move(track));
  }
  for (auto& [gone, track] : before) {
    interrupt(ContactState::UNKNOWN, "no longer monitored", report.now, &track);
  }
}

void ContactStateTracker::look(const CycleReport& report, const MonitoredPair& pair,
                               const PairSummary& summary, const StepVerdicts& steps,
                               Track* track) {
  if (pair.allowed) return interrupt(ContactState::ALLOWED, "allowed", report.now, track);
  if (track->state.state == ContactState::ALLOWED) {
    interrupt(ContactState::UNKNOWN, "not looked at yet", report.now, track);
  }
  std::string problem = bodyProblem(report, pair);
  if (!isOfCycle(report.bodies, pair) || (!problem.empty() && isPartnersProblem(report, pair))) {
    if (!problem.empty() && !track->isKnown()) track->state.reason = problem;
    return;
  }
  const StepVerdict step = steps.of(pair);
  if (track->isKnown() && report.header.stamp < track->state.stamp) {
    return lookBack(report, step, track);
  }
  if (!problem.empty()) return interrupt(ContactState::UNKNOWN, problem, report.now, track);
  const PairFinding finding(report, pair, summary, rules_);
  problem = finding.problem();
  if (!problem.empty()) {
    interrupt(ContactState::UNKNOWN, problem, report.now, track);
    track->state.distance_low = finding.distanceLowM();
    return;
  }
  ContactState state = finding.state();
  if (!lookAtStep(report, step, &state, track)) return;
  const bool goes_on = resumes(state, report.now, *track);
  const std::uint8_t before = track->state.state;
  enter(std::move(state), goes_on ? track->entered_before : report.header.stamp, track);
  debounce(report.header.stamp, before, step.first_low, track);
}

// Whether the state is known, with what the step says of it.
bool ContactStateTracker::lookAtStep(const CycleReport& report, const StepVerdict& step,
                                     ContactState* state, Track* track) {
  if (!isApart(*state)) return true;
  if (step.touched()) {
    pass(step, state);
    return true;
  }
  // Who reads NONE after a state that was known takes it for "not in between" either.
  if (step.problem.empty() || (!step.has_step && !track->isKnown())) return true;
  interrupt(ContactState::UNKNOWN, step.problem, report.now, track);
  return false;
}

// A step that ends before the stamp of what is known: the pair's other body had a cycle meanwhile,
// with an older state of the one that this step is of.
void ContactStateTracker::lookBack(const CycleReport& report, const StepVerdict& step,
                                   Track* track) {
  if (!isApart(track->state)) return;
  ContactState state = track->state;
  if (!lookAtStep(report, step, &state, track) || isApart(state)) return;
  const std::uint8_t before = track->state.state;
  enter(std::move(state), track->state.stamp, track);
  debounce(report.header.stamp, before, step.first_low, track);
}

// Whether `state` is what a short UNKNOWN interrupted.
bool ContactStateTracker::resumes(const ContactState& state, const ros::Time& now,
                                  const Track& track) const {
  return track.state.state == ContactState::UNKNOWN && track.state_before == state.state &&
         secondsBetween(now, track.entered) < rules_.since_survives_s;
}

void ContactStateTracker::enter(ContactState state, const ros::Time& when, Track* track) {
  if (track->state.state != state.state) track->entered = when;
  track->state = std::move(state);
}

// To a state that no geometry speaks for.
void ContactStateTracker::interrupt(std::uint8_t state, const std::string& reason,
                                    const ros::Time& now, Track* track) {
  ContactState next;
  next.body_a = track->state.body_a;
  next.body_b = track->state.body_b;
  next.state = state;
  next.reason = state == ContactState::UNKNOWN ? reason : "";
  next.min_separation = std::numeric_limits<float>::quiet_NaN();
  if (track->state.state != ContactState::UNKNOWN) {
    track->state_before = track->state.state;
    track->entered_before = track->entered;
  }
  enter(std::move(next), now, track);
  if (track->open) addEvent(*track, ContactEvent::END, now, reason);
  track->open = false;
  track->cycles = 0;
}

// A contact between two cycles is an event of its own, unless it is the rest of one that was there
// in the cycle before, or keeps one open that was about to end.
void ContactStateTracker::debounce(const ros::Time& stamp, std::uint8_t before, float first_low,
                                   Track* track) {
  const bool anew = track->state.state == ContactState::PASSED && before != ContactState::CONTACT;
  if (anew && !track->open) addEvent(*track, ContactEvent::PASSED, stamp, "", first_low);
  const bool touching = track->state.state == ContactState::CONTACT || (anew && track->open);
  track->cycles = touching == track->open ? 0 : track->cycles + 1;
  if (track->cycles < (track->open ? rules_.debounce_off_cycles : rules_.debounce_on_cycles))
    return;
  track->open = touching;
  track->cycles = 0;
  addEvent(*track, touching ? ContactEvent::BEGIN : ContactEvent::END, stamp, "");
}

bool ContactStateTracker::expire(const ros::Time& now, const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  bool any = false;
  for (Track& track : tracks_) {
    if (!track.isKnown() || secondsBetween(now, track.state.stamp) <= rules_.max_age_s) continue;
    interrupt(ContactState::UNKNOWN, why, now, &track);
    any = true;
  }
  return any;
}

ContactStates ContactStateTracker::states(const ros::Time& stamp, const ros::Time& now) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  ContactStates message;
  message.header.stamp = stamp;
  message.header.frame_id = frame_;
  message.cycle = cycle_;
  message.complete = true;
  message.tolerance = rules_.tolerance_m;
  ros::Time oldest = now;
  message.states.reserve(tracks_.size());
  for (const Track& track : tracks_) {
    ContactState state = track.state;
    if (track.isKnown()) {
      oldest = std::min(oldest, state.stamp);
    } else {
      state.stamp = now;
    }
    state.since = toDuration(std::max(0.0, secondsBetween(state.stamp, track.entered)));
    message.complete = message.complete && state.state != ContactState::UNKNOWN;
    message.states.push_back(std::move(state));
  }
  message.age = toDuration(secondsBetween(now, oldest));
  return message;
}

std::vector<ContactEvent> ContactStateTracker::takeEvents() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(events_, {});
}

void ContactStateTracker::forget(const std::string& body, const std::string& reason,
                                 const ros::Time& now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (Track& track : tracks_) {
    const ContactState& state = track.state;
    if (!body.empty() && state.body_a != body && state.body_b != body) continue;
    if (track.isKnown()) interrupt(ContactState::UNKNOWN, reason, now, &track);
    track.state_before = ContactState::UNKNOWN;
  }
}

void ContactStateTracker::addEvent(const Track& track, std::uint8_t type, const ros::Time& stamp,
                                   const std::string& reason, float first_low) {
  ContactEvent event;
  event.header.stamp = stamp;
  event.header.frame_id = frame_;
  event.body_a = track.state.body_a;
  event.body_b = track.state.body_b;
  event.type = type;
  event.pair_count = track.state.pair_count;
  event.first_low = first_low;
  event.reason = reason;
  events_.push_back(std::move(event));
}

}  // namespace deformable_contact_monitor
