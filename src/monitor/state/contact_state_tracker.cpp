// Keeps the state of each monitored pair over time: which cycle's finding holds, since when, and
// which events follow from it.
#include "monitor/state/contact_state_tracker.h"

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "monitor/input/usable_stamp.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// Returns whether each body that is not known is an object that did not trigger this cycle. Such an
// object has cycles of its own, which tell more about the pair.
bool isPartnersProblem(const CycleReport& report, const MonitoredPair& pair) {
  const auto isKnownOrPartner = [](const BodyStatus& body, PartId part) {
    return bodyProblem(body, part).empty() ||
           (body.kind == BodyKind::kDeformable && !body.triggered);
  };
  return isKnownOrPartner(report.bodies.at(pair.a), pair.part_a) &&
         isKnownOrPartner(report.bodies.at(pair.b), pair.part_b);
}

// Returns whether the cycle is of an object of the pair that has no mesh: it was refused or
// deleted.
bool hasLostMesh(const CycleReport& report, const MonitoredPair& pair) {
  const BodyStatus &a = report.bodies.at(pair.a), &b = report.bodies.at(pair.b);
  return (a.triggered && a.without_mesh) || (b.triggered && b.without_mesh);
}

// Returns the older stamp of the data that the pair's state is found with.
ros::Time oldestStamp(const CycleReport& report, const MonitoredPair& pair) {
  ros::Time oldest = report.header.stamp;
  for (const BodyId id : {pair.a, pair.b}) {
    const ros::Time& stamp = report.bodies.at(id).stamp;
    if (!stamp.isZero()) oldest = std::min(oldest, stamp);
  }
  return oldest;
}

// Does the same as comparing with nameOf(), without making the names of bodies anew.
bool isNamed(const std::string& name, const BodyStatus& body, PartId part) {
  return part == 0 ? name == body.name : name == nameOf(body, part);
}

ContactState unknown(const std::string& body_a, const std::string& body_b,
                     const std::string& reason) {
  ContactState state;
  state.body_a = body_a;
  state.body_b = body_b;
  state.state = ContactState::UNKNOWN;
  state.reason = reason;
  state.min_separation = std::numeric_limits<float>::quiet_NaN();
  return state;
}

bool isApart(const ContactState& state) {
  return state.state == ContactState::NONE || state.state == ContactState::NEAR;
}

constexpr std::uint32_t kHeldBit = 1U << 8U;  // of the number of a piece
constexpr unsigned kPieceBits = 9;

// Returns a number that the piece keeps when other triangles are held.
std::uint32_t numberOf(const BodyStatus& body, PartId piece) {
  if (body.parts == nullptr || !body.parts->isHeld(piece)) return piece;
  const std::vector<PartId>& held_of = body.parts->held_of;
  return kHeldBit | held_of.at(piece - (body.parts->pieceCount() - held_of.size()));
}

bool isHeldPart(const BodyStatus& body, PartId part) {
  return part != 0 && part == body.parts->heldPart();
}

// Returns the numbers of the pieces that a part, or what is in no part, consists of now.
std::vector<std::uint32_t> numbersOf(const BodyStatus& body, std::uint32_t part) {
  std::vector<std::uint32_t> numbers;
  for (const PartId piece : piecesOf(body, 0)) {
    const std::uint32_t number = numberOf(body, piece);
    if ((number & ~kHeldBit) == part) numbers.push_back(number);
  }
  return numbers;
}

// Returns whether the piece is of the part; every piece is of part 0, which stands for the body.
bool isOf(const BodyStatus& body, PartId piece, PartId part) {
  return part == 0 || body.parts->has(part, piece);
}

// Returns what is held of the body, if its pieces are known in the mesh that is in use.
std::shared_ptr<const HeldPart> heldOf(const CycleReport& report, BodyId body) {
  const BodyParts* const parts = report.bodies.at(body).parts.get();
  if (parts == nullptr || parts->heldPart() == 0) return nullptr;
  const auto found = report.attached.find(report.bodies.at(body).name);
  return found == report.attached.end() ? nullptr : found->second.part;
}

}  // namespace

ContactStateTracker::ContactStateTracker(const StateRules& rules) : rules_(rules) {
  if (rules.debounce_on_cycles < 1 || rules.debounce_off_cycles < 1) {
    throw std::invalid_argument("debounce cycles must be at least 1");
  }
}

void ContactStateTracker::update(const CycleReport& report) {
  const PairStates found(report, rules_);  // before the lock, because it may take long
  const std::lock_guard<std::mutex> lock(mutex_);
  frame_ = report.header.frame_id;
  cycle_ = report.cycle;
  is_list_ = std::none_of(report.bodies.begin(), report.bodies.end(),
                          [](const BodyStatus& body) { return body.triggered; });
  const bool are_others = listPairs(report);
  if (are_others || report.allowed_parts != allowed_parts_ || report.attached != attached_) {
    listLeftOut(report);
  }
  allowed_parts_ = report.allowed_parts;
  attached_ = report.attached;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    updateTrack(report, statePair(report, i), found, &tracks_[i]);
  }
}

// Keeps the tracks of pairs that remain, in the report's order, and ends those that are gone.
bool ContactStateTracker::listPairs(const CycleReport& report) {
  using Names = std::pair<std::string, std::string>;
  const auto names = [&report](const MonitoredPair& pair) {
    return Names(nameOf(report.bodies.at(pair.a), pair.part_a),
                 nameOf(report.bodies.at(pair.b), pair.part_b));
  };
  bool same = tracks_.size() == statePairCount(report);
  for (std::size_t i = 0; same && i < tracks_.size(); ++i) {
    const MonitoredPair& pair = statePair(report, i);
    same = isNamed(tracks_[i].state.body_a, report.bodies.at(pair.a), pair.part_a) &&
           isNamed(tracks_[i].state.body_b, report.bodies.at(pair.b), pair.part_b);
  }
  if (same) return false;
  std::map<Names, Track> before;
  for (Track& track : tracks_) {
    before.emplace(Names(track.state.body_a, track.state.body_b), std::move(track));
  }
  tracks_.clear();
  for (std::size_t i = 0; i < statePairCount(report); ++i) {
    const MonitoredPair& pair = statePair(report, i);
    const auto found = before.find(names(pair));
    if (found != before.end()) {
      tracks_.push_back(std::move(found->second));
      before.erase(found);
      continue;
    }
    Track track;
    std::tie(track.state.body_a, track.state.body_b) = names(pair);
    track.whole_a = report.bodies.at(pair.a).name;
    track.whole_b = report.bodies.at(pair.b).name;
    interrupt(ContactState::UNKNOWN, "not looked at yet", report.now, &track);
    track.state_before = ContactState::UNKNOWN;
    tracks_.push_back(std::move(track));
  }
  for (auto& [gone, track] : before) {
    interrupt(ContactState::UNKNOWN, "no longer monitored", report.now, &track);
  }
  return true;
}

// If an object is held anew, a piece that was not held may have lost triangles to one that is.
// Which triangles a held piece had before is not known any more.
bool ContactStateTracker::LeftOut::covers(const LeftOut& before, const BodyStatus& a,
                                          const BodyStatus& b) const {
  const bool same_a = held_a == before.held_a, same_b = held_b == before.held_b;
  if (same_a && same_b) {
    return std::includes(pieces.begin(), pieces.end(), before.pieces.begin(), before.pieces.end());
  }
  const auto has = [this](std::uint32_t of_a, std::uint32_t of_b) {
    return std::binary_search(pieces.begin(), pieces.end(), of_a << kPieceBits | of_b);
  };
  const auto isLeftOut = [&](std::uint32_t piece) {
    const std::uint32_t of_a = piece >> kPieceBits, of_b = piece & ((1U << kPieceBits) - 1);
    if ((!same_a && (of_a & kHeldBit) != 0) || (!same_b && (of_b & kHeldBit) != 0)) return false;
    for (const std::uint32_t now_a : same_a ? std::vector{of_a} : numbersOf(a, of_a)) {
      for (const std::uint32_t now_b : same_b ? std::vector{of_b} : numbersOf(b, of_b)) {
        if (!has(now_a, now_b) && !(&a == &b && has(now_b, now_a))) return false;
      }
    }
    return true;
  };
  return std::all_of(before.pieces.begin(), before.pieces.end(), isLeftOut);
}

// Triangles that a state did not cover may touch: those of pieces that were left out and are not
// any more, and those of another hold.
void ContactStateTracker::listLeftOut(const CycleReport& report) {
  std::map<std::pair<BodyId, BodyId>, std::vector<PartPair>> by_pair;
  if (report.allowed_parts != nullptr) {
    for (const PartPair& one : *report.allowed_parts) {
      by_pair[{one.body_a, one.body_b}].push_back(one);
    }
  }
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const MonitoredPair& pair = statePair(report, i);
    const BodyStatus &a = report.bodies.at(pair.a), &b = report.bodies.at(pair.b);
    LeftOut now;
    now.held_a = heldOf(report, pair.a);
    now.held_b = heldOf(report, pair.b);
    const auto found = by_pair.find({pair.a, pair.b});
    if (found != by_pair.end()) {
      for (const PartPair& one : found->second) {
        // Of self-contact, the part of the pair is either of the two.
        const bool is_of_pair =
            pair.a == pair.b ? isOf(b, one.part_a, pair.part_b) || isOf(b, one.part_b, pair.part_b)
                             : isOf(a, one.part_a, pair.part_a) && isOf(b, one.part_b, pair.part_b);
        if (!is_of_pair) continue;
        now.pieces.push_back(numberOf(a, one.part_a) << kPieceBits | numberOf(b, one.part_b));
      }
      std::sort(now.pieces.begin(), now.pieces.end());
    }
    const LeftOut& before = tracks_[i].left_out;
    const bool is_other_part = (isHeldPart(a, pair.part_a) && now.held_a != before.held_a) ||
                               (isHeldPart(b, pair.part_b) && now.held_b != before.held_b);
    if (is_other_part || !now.covers(before, a, b)) {
      Track& track = tracks_[i];
      if (isApart(track.state)) {
        interrupt(ContactState::UNKNOWN, "not looked at yet", report.now, &track);
      }
      if (track.state_before != ContactState::CONTACT) {
        track.state_before = ContactState::UNKNOWN;  // it did not cover these triangles
      }
    }
    tracks_[i].left_out = std::move(now);
  }
}

void ContactStateTracker::updateTrack(const CycleReport& report, const MonitoredPair& pair,
                                      const PairStates& found, Track* track) {
  if (pair.allowed) return interrupt(ContactState::ALLOWED, "allowed", report.now, track);
  if (track->state.state == ContactState::ALLOWED) {
    interrupt(ContactState::UNKNOWN, "not looked at yet", report.now, track);
  }
  const std::string problem = bodyProblem(report, pair);
  if (!isOfCycle(report.bodies, pair) || (!problem.empty() && isPartnersProblem(report, pair))) {
    noteBodyProblem(problem, track);
    return;
  }
  if (report.epoch < epoch_) return;
  const IntervalFinding interval = found.inInterval(pair);
  const bool is_older = track->isKnown() && report.header.stamp < track->state.stamp;
  if (is_older && !hasLostMesh(report, pair)) return updateOlder(report, interval, track);
  ContactState state = found.atStamp(pair);
  if (state.state == ContactState::UNKNOWN) {
    interrupt(ContactState::UNKNOWN, state.reason, report.now, track);
    track->state.distance_low = state.distance_low;
    return;
  }
  if (!applyInterval(report, interval, &state, track)) return;
  track->oldest_data = oldestStamp(report, pair);
  const bool goes_on = resumes(state, interval, report.now, *track);
  const std::uint8_t before = track->state.state;
  enter(std::move(state), goes_on ? track->entered_before : report.header.stamp, track);
  debounce(report.header.stamp, before, interval.first_low, track);
}

// Keeps the reason of an UNKNOWN pair up to date between its cycles. `problem`: why one of its
// bodies is not known; empty: the report knows no reason. The list of all pairs looks at the meshes
// of all objects, so what it said before is over then.
void ContactStateTracker::noteBodyProblem(const std::string& problem, Track* track) const {
  if (track->isKnown()) return;
  if (!problem.empty()) {
    track->state.reason = problem;
  } else if (is_list_ && !track->listed_problem.empty() &&
             track->state.reason == track->listed_problem) {
    track->state.reason = "not looked at yet";
  }
  if (is_list_) track->listed_problem = problem;
}

// Adds to a state what the time interval before it says. Returns false if the pair is UNKNOWN
// because of that.
bool ContactStateTracker::applyInterval(const CycleReport& report, const IntervalFinding& interval,
                                        ContactState* state, Track* track) {
  if (!isApart(*state)) return true;
  if (interval.touched()) {
    interval.setPassed(state);
    return true;
  }
  // NONE also says that nothing touched since the last cycle. Before the first known state, and
  // after a reset, there is nothing to say that about, so a pair without an interval may be NONE.
  // An UNKNOWN in between changes nothing: what came after it was not looked at either.
  const bool joins = !track->isKnown() || interval.from <= track->state.stamp;
  if (interval.problem.empty() && joins) return true;
  const bool was_known = track->isKnown() || track->state_before != ContactState::UNKNOWN;
  if (!interval.has_interval && !was_known) return true;
  interrupt(ContactState::UNKNOWN,
            joins ? interval.problem : "the step begins later than the state before", report.now,
            track);
  return false;
}

// Handles a report that is older than what is known: the other body of the pair had a cycle
// meanwhile, which used an older state of the body that this report is about. Only a contact in
// the report's interval is news.
void ContactStateTracker::updateOlder(const CycleReport& report, const IntervalFinding& interval,
                                      Track* track) {
  if (!isApart(track->state)) return;
  ContactState state = track->state;
  if (!applyInterval(report, interval, &state, track) || isApart(state)) return;
  const std::uint8_t before = track->state.state;
  enter(std::move(state), track->state.stamp, track);
  debounce(report.header.stamp, before, interval.first_low, track);
}

// Returns whether `state` was interrupted only by a short UNKNOWN. With swept motion, a pair that
// is apart was so all the time only if the interval reaches back to where it was last found apart.
bool ContactStateTracker::resumes(const ContactState& state, const IntervalFinding& interval,
                                  const ros::Time& now, const Track& track) const {
  if (isApart(state) && (!interval.has_interval || interval.from > track.found_before)) {
    return false;
  }
  return track.state.state == ContactState::UNKNOWN && track.state_before == state.state &&
         secondsBetween(now, track.entered) < rules_.since_survives_s;
}

void ContactStateTracker::enter(ContactState state, const ros::Time& when, Track* track) {
  if (track->state.state != state.state) track->entered = when;
  track->state = std::move(state);
}

// Enters UNKNOWN or ALLOWED, which ends an open contact at once.
void ContactStateTracker::interrupt(std::uint8_t state, const std::string& reason,
                                    const ros::Time& now, Track* track) {
  ContactState next = unknown(track->state.body_a, track->state.body_b, reason);
  next.state = state;
  if (state != ContactState::UNKNOWN) next.reason.clear();
  if (track->state.state != ContactState::UNKNOWN) {
    track->state_before = track->state.state;
    track->entered_before = track->entered;
    track->found_before = track->state.stamp;
  }
  enter(std::move(next), now, track);
  if (track->open) addEvent(*track, ContactEvent::END, now, reason);
  track->open = false;
  track->cycles = 0;
}

// Counts the cycles for and against a contact, and adds the events that follow. `before` is the
// state of the cycle before. A PASSED is an event of its own, with two exceptions: after CONTACT it
// is the end of that contact, and while a contact is open it counts as one more cycle of it.
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
    const bool is_ahead = secondsBetween(now, track.state.stamp) < -kMaxAheadS;
    const bool is_old = secondsBetween(now, track.oldest_data) > rules_.max_age_s;
    if (!track.isKnown() || (!is_old && !is_ahead)) continue;
    interrupt(ContactState::UNKNOWN, is_ahead ? "time jump: the clock went back" : why, now,
              &track);
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
  message.complete = !now.isZero();
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
    const ros::Time& entered = track.entered.isZero() ? now : track.entered;  // without a clock
    state.since = toDuration(std::max(0.0, secondsBetween(state.stamp, entered)));
    if (now.isZero() && state.state != ContactState::UNKNOWN) {
      state = unknown(state.body_a, state.body_b, "no clock: ROS time is zero");
    }
    message.complete = message.complete && state.state != ContactState::UNKNOWN;
    message.states.push_back(std::move(state));
  }
  message.age = now.isZero() ? ros::Duration() : toDuration(secondsBetween(now, oldest));
  return message;
}

std::vector<ContactEvent> ContactStateTracker::takeEvents() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(events_, {});
}

void ContactStateTracker::forget(const std::string& body, const std::string& reason,
                                 const ros::Time& now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  forgetLocked(body, reason, now);
}

void ContactStateTracker::discard(const std::string& reason, const ros::Time& now,
                                  std::uint64_t epoch) {
  const std::lock_guard<std::mutex> lock(mutex_);
  epoch_ = std::max(epoch_, epoch);
  forgetLocked("", reason, now);
}

// The caller holds mutex_.
void ContactStateTracker::forgetLocked(const std::string& body, const std::string& reason,
                                       const ros::Time& now) {
  for (Track& track : tracks_) {
    if (!body.empty() && track.whole_a != body && track.whole_b != body) continue;
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
