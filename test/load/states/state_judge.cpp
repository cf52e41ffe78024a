// Judges every message of states by the truth.
#include "state_judge.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <utility>

#include "core/vector3.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kRounding = 1e-5;  // [m] of float32 vertices, with room to spare
constexpr double kPad = 0.004;      // [m] PASSED may be claimed of bodies so near to each other
constexpr double kFromTheFutureS = 1;

bool isKnown(const ContactState& state) {
  return state.state != ContactState::UNKNOWN && state.state != ContactState::ALLOWED;
}

// Returns by how much a NEAR state's points are off from each other [m]: with its distance and its
// normal the way leads from a's point to b's, or to at most `tolerance` beyond it.
double gapOfPoints(const ContactState& state, double tolerance) {
  const auto vector = [](const geometry_msgs::Point32& p) { return Vec3d{p.x, p.y, p.z}; };
  const Vec3d way = vector(state.point_b) - vector(state.point_a), normal = vector(state.normal);
  const double distance = length(way);
  return std::max({length(way - normal * distance), state.min_separation - distance,
                   distance - tolerance - state.min_separation});
}

bool isApart(const ContactState& state) {
  return state.state == ContactState::NONE || state.state == ContactState::NEAR;
}

const char* nameOf(std::uint8_t state) {
  constexpr const char* kNames[] = {"NONE", "NEAR", "CONTACT", "ALLOWED", "UNKNOWN", "PASSED"};
  return state < 6 ? kNames[state] : "?";
}

}  // namespace

void StateJudge::fault(const ContactState& state, const std::string& what) {
  std::ostringstream text;
  text << state.body_a << "/" << state.body_b << " " << nameOf(state.state) << " at " << state.stamp
       << ": " << what;
  addFault(text.str());
}

std::optional<std::size_t> StateJudge::objectOf(const std::string& name) const {
  for (std::size_t i = 0; i < parameters_.objects.size(); ++i) {
    if (parameters_.objects[i].name == name) return i;
  }
  return std::nullopt;
}

void StateJudge::beginCycle(const MeshInputs& meshes) {
  ++begun_;
  refused_.clear();
  for (const MeshInput& input : meshes) refused_.push_back(!input.counters().problem.empty());
}

void StateJudge::forget(const std::string& body) {
  if (body.empty()) {
    starts_.clear();
  } else {
    starts_.erase(body);
  }
}

void StateJudge::answer(bool is_enabled) {
  const bool was_enabled = std::exchange(is_enabled_, is_enabled);
  if (!is_enabled || was_enabled) floor_ = begun_;
}

void StateJudge::judge(const ContactStates& message, bool expired) {
  for (const ContactState& state : message.states) judgeState(nullptr, state, expired);
}

void StateJudge::judgeCycle(const CycleReport& report, const ContactStates& message) {
  for (const ContactState& state : message.states) judgeState(&report, state, false);
  rememberCycle(report);
}

void StateJudge::judgeState(const CycleReport* report, const ContactState& state, bool expired) {
  ++states_;
  const Names names(state.body_a, state.body_b);
  const auto found = known_.find(names);
  if (!isKnown(state)) {
    if (found != known_.end()) known_.erase(found);
    return;
  }
  ++known_count_;
  Known* const before = found == known_.end() ? nullptr : &found->second;
  const bool is_kept =
      before != nullptr && before->state == state.state && before->stamp == state.stamp;
  if (is_kept) {
    judgeKept(state, *before, expired);
    if (report != nullptr) judgeOlder(*report, state, before);
    return;
  }
  if (!is_enabled_) fault(state, "though the monitor is disabled");
  if (report == nullptr) {
    fault(state, "no cycle found it");
  } else {
    if (begun_ <= floor_) fault(state, "of a cycle that began before ~reset or ~set_enabled");
    judgeClaim(*report, state, before);
  }
  Known now{state.state, state.stamp, begun_, {}, {}};
  if (before != nullptr) {
    now.reached_a = before->reached_a;
    now.reached_b = before->reached_b;
  }
  if (report != nullptr) reach(*report, state, &now);
  known_[names] = now;
}

void StateJudge::reach(const CycleReport& report, const ContactState& state, Known* known) {
  for (const BodyStatus& body : report.bodies) {
    if (body.name == state.body_a) known->reached_a = std::max(known->reached_a, body.stamp);
    if (body.name == state.body_b) known->reached_b = std::max(known->reached_b, body.stamp);
  }
}

// Judges a state that stays in a cycle whose stamp is no newer: the other object had its cycle
// before. The step of that cycle belongs to what the state says.
void StateJudge::judgeOlder(const CycleReport& report, const ContactState& state, Known* known) {
  if (report.header.stamp > known->stamp || parameters_.motion != Motion::kSwept) return;
  if (!objectOf(state.body_a) || !objectOf(state.body_b)) return;
  const auto find = [&report](const std::string& name) {
    return std::find_if(report.bodies.begin(), report.bodies.end(),
                        [&name](const BodyStatus& one) { return one.name == name; });
  };
  const auto a = find(state.body_a), b = find(state.body_b);
  if (a == report.bodies.end() || b == report.bodies.end() || !(a->triggered || b->triggered)) {
    return;
  }
  const auto is_known = [](const BodyStatus& body) {
    return !body.stamp.isZero() && body.unknown_because.empty();
  };
  if (!is_known(*a) || !is_known(*b)) return;
  const std::optional<Used> used_a = usedOf(*a), used_b = usedOf(*b);
  if (!used_a || !used_b) return;
  if (isApart(state)) judgeInterval({&report, &state, &*a, &*b, *used_a, *used_b}, known);
  reach(report, state, known);
}

void StateJudge::judgeKept(const ContactState& state, const Known& before, bool expired) {
  if (!is_enabled_) fault(state, "still, though the monitor is disabled");
  if (is_enabled_ && before.cycle <= floor_) fault(state, "still, after ~reset or ~set_enabled");
  const double age_s = secondsBetween(world_.now(), state.stamp);
  if (expired && isTooOld(world_.now(), state.stamp)) fault(state, "too old");
  if (expired && age_s < -kFromTheFutureS) fault(state, "still, from the future");
}

// The clock counts nanoseconds, and 1e-9 * 300000000 is more than 0.3.
bool StateJudge::isTooOld(const ros::Time& now, const ros::Time& stamp) const {
  return nanosecondsBetween(now, stamp) > std::llround(1e9 * parameters_.max_mesh_age_s);
}

// Finds out what the cycle used of a body; nothing: the world knows of no valid data.
std::optional<StateJudge::Used> StateJudge::usedOf(const BodyStatus& body) const {
  Used used;
  used.stamp = body.stamp;
  used.frame = body.name;
  used.object = objectOf(body.name);
  if (used.object) {
    const SentMesh* const mesh = world_.mesh(*used.object, body.stamp);
    if (mesh == nullptr || !mesh->is_good) return std::nullopt;
    used.frame = mesh->frame;
    used.topology = mesh->topology;
    used.local = mesh->shape;
  } else {
    const SmallShape* const link = world_.link(body.name);
    if (link == nullptr) return std::nullopt;
    used.local = *link;
  }
  const std::optional<RigidTransform> pose = world_.poseAt(used.frame, body.stamp);
  if (!pose) return std::nullopt;
  used.pose = *pose;
  used.placed = used.local;
  for (Vec3d& v : used.placed.vertices) v = transformed(*pose, v);
  return used;
}

void StateJudge::judgeClaim(const CycleReport& report, const ContactState& state,
                            const Known* before) {
  const auto body = [&report](const std::string& name) {
    return &*std::find_if(report.bodies.begin(), report.bodies.end(),
                          [&name](const BodyStatus& one) { return one.name == name; });
  };
  const BodyStatus *const a = body(state.body_a), *const b = body(state.body_b);
  const std::optional<Used> used_a = usedOf(*a), used_b = usedOf(*b);
  if (!used_a || !used_b) {
    return fault(state, (used_a ? b : a)->name + " has no valid data of the stamp that was used");
  }
  const Claim claim{&report, &state, a, b, *used_a, *used_b};
  if (!judgeData(claim)) return;
  ++judged_;
  passed_ += state.state == ContactState::PASSED;
  if (state.stamp == report.header.stamp) judgeAtStamp(claim);
  if (parameters_.motion == Motion::kSwept) judgeInterval(claim, before);
}

// Judges whether these data may be used in a cycle of that stamp.
bool StateJudge::judgeData(const Claim& claim) {
  const ros::Time& stamp = claim.report->header.stamp;
  const std::size_t faults = faults_.size();
  if (secondsBetween(stamp, claim.report->now) > kFromTheFutureS) {
    fault(*claim.state, "from the future");
  }
  if (claim.state->stamp < stamp) fault(*claim.state, "older than its cycle");
  if (!claim.a->triggered && !claim.b->triggered) fault(*claim.state, "not of this cycle");
  for (const auto& [used, body] : {std::pair(&claim.used_a, claim.a), {&claim.used_b, claim.b}}) {
    const double age_s = secondsBetween(stamp, used->stamp);
    if (age_s < 0 || isTooOld(stamp, used->stamp) || (!used->object && age_s != 0)) {
      fault(*claim.state, body->name + " is as it was " + std::to_string(age_s) + " s before");
    }
    const auto start = starts_.find(body->name);
    if (used->object && start != starts_.end() && start->second.bodies.count(body->name) > 0 &&
        start->second.bodies.at(body->name).stamp > used->stamp && start->second.stamp <= stamp) {
      fault(*claim.state, body->name + " has had a newer mesh in a cycle");
    }
    if (used->object && refused_[*used->object]) {
      fault(*claim.state, "the newest mesh of " + body->name + " was refused");
    }
  }
  return faults == faults_.size();
}

void StateJudge::judgeAtStamp(const Claim& claim) {
  const SmallShape &a = claim.used_a.placed, &b = claim.used_b.placed;
  const ContactState& state = *claim.state;
  const double distance = distanceBetween(a, b);
  const double tolerance = parameters_.detector.tolerance_m;
  const auto [least, most] = std::minmax_element(margins_m_.begin(), margins_m_.end());
  const bool is_whole = a.brokenShare() == 0 && b.brokenShare() == 0;
  double depth = -1;
  if (parameters_.containment && is_whole) {
    if (claim.state->body_b != "cloth") depth = std::max(depth, depthWithin(a, b));
    if (claim.state->body_a != "cloth") depth = std::max(depth, depthWithin(b, a));
  }
  const std::string found = "the distance is " + std::to_string(distance) + " m";
  if (state.state == ContactState::CONTACT) {
    if (state.inside && !is_whole) return;  // what is left of a broken surface may be inside
    if (distance > tolerance + kRounding && depth < -kRounding) fault(state, found);
    return;
  }
  if (distance == 0) fault(state, "they touch");
  if (depth > kRounding) fault(state, "one is within the other");
  if (state.state == ContactState::NONE && distance < *least - kRounding) fault(state, found);
  if (state.state == ContactState::NEAR && distance > *most + tolerance + kRounding) {
    fault(state, found);
  }
  if (state.state == ContactState::NEAR &&
      (state.min_separation > distance + kRounding ||
       state.min_separation < distance - tolerance - kRounding)) {
    fault(state, found + " and not " + std::to_string(state.min_separation));
  }
  if (state.state == ContactState::NEAR && gapOfPoints(state, tolerance) > kRounding) {
    fault(state, "its points are not where it says");
  }
  const double broken = std::max(a.brokenShare(), b.brokenShare());
  if (broken > parameters_.tolerated_rejects + 1e-9) fault(state, "triangles are not finite");
}

// Returns the cycle of the partner if it came after `own` and knew both bodies, else `own`. The
// partner is the object of a pair of two objects that did not trigger this cycle.
const StateJudge::Start* StateJudge::laterOfPartner(const Start* own, const Claim& claim) const {
  for (const auto& [used, body] : {std::pair(&claim.used_a, claim.a), {&claim.used_b, claim.b}}) {
    const auto found = starts_.find(body->name);
    if (body->triggered || !used->object || found == starts_.end()) continue;
    const Start& partners = found->second;
    const bool knows_both =
        partners.bodies.count(claim.a->name) > 0 && partners.bodies.count(claim.b->name) > 0;
    if (knows_both && partners.cycle > own->cycle && partners.stamp >= own->stamp &&
        partners.stamp <= claim.report->header.stamp) {
      return &partners;
    }
  }
  return own;
}

// Returns the cycle before of whoever triggered this one, or a later one of the partner, from which
// the pair's interval starts; null if there is none.
const StateJudge::Start* StateJudge::startOf(const Claim& claim) const {
  const Start* latest = nullptr;
  const bool is_of_links = !claim.used_a.object && !claim.used_b.object;
  for (const auto& [used, body] : {std::pair(&claim.used_a, claim.a), {&claim.used_b, claim.b}}) {
    if (!body->triggered || (!is_of_links && !used->object)) continue;
    const auto found = starts_.find(is_of_links ? "robot" : body->name);
    if (found == starts_.end()) continue;
    const Start& start = found->second;
    if (isTooOld(claim.report->header.stamp, start.stamp)) continue;
    if (used->object && !hasBody(start, body->name, *used)) continue;
    if (latest == nullptr || latest->cycle < start.cycle) latest = &start;
  }
  if (latest != nullptr) latest = laterOfPartner(latest, claim);
  if (latest != nullptr && beginsFrom(*latest, claim)) return latest;
  // The cycle of the partner, which has not moved since, may be the first that knew both.
  for (const auto& [used, body] : {std::pair(&claim.used_a, claim.a), {&claim.used_b, claim.b}}) {
    const auto found = starts_.find(body->name);
    if (body->triggered || !used->object || found == starts_.end()) continue;
    const auto partner = found->second.bodies.find(body->name);
    const bool has_moved =
        partner == found->second.bodies.end() || partner->second.stamp != used->stamp;
    if (!has_moved && beginsFrom(found->second, claim)) return &found->second;
  }
  return nullptr;
}

// Returns whether the body was there before, with the same triangles and frame.
bool StateJudge::hasBody(const Start& start, const std::string& name, const Used& now) {
  const auto from = start.bodies.find(name);
  return from != start.bodies.end() && from->second.stamp <= now.stamp &&
         from->second.topology == now.topology && from->second.frame == now.frame;
}

bool StateJudge::beginsFrom(const Start& start, const Claim& claim) {
  return hasBody(start, claim.a->name, claim.used_a) && hasBody(start, claim.b->name, claim.used_b);
}

void StateJudge::judgeInterval(const Claim& claim, const Known* before) {
  const ContactState& state = *claim.state;
  if (state.state == ContactState::CONTACT) return;
  const Start* const start = startOf(claim);
  if (start == nullptr) {
    if (before != nullptr) fault(state, "it was known before, and no step joins");
    return;
  }
  const bool has_one_clock = !claim.used_a.object || !claim.used_b.object;
  if (has_one_clock && before != nullptr && before->stamp < start->stamp) {
    fault(state, "the step begins later than the state before");
  }
  if (isApart(state) && before != nullptr &&
      (start->bodies.at(claim.a->name).stamp > before->reached_a ||
       start->bodies.at(claim.b->name).stamp > before->reached_b)) {
    fault(state, "the step begins later than what was known before");
  }
  const std::optional<SmallMotion> a = motionOf(start->bodies.at(claim.a->name), claim.used_a);
  const std::optional<SmallMotion> b = motionOf(start->bodies.at(claim.b->name), claim.used_b);
  if (!a || !b) {
    if (before != nullptr) fault(state, "transforms are missing in the step");
    return;
  }
  const SmallShape middle_a = a->at(0.5), middle_b = b->at(0.5);
  const double broken = std::max(middle_a.brokenShare(), middle_b.brokenShare());
  if (isApart(state) && before != nullptr && broken > parameters_.tolerated_rejects + 1e-9) {
    fault(state, "in the step, triangles are not finite");
  }
  const Encounter met = encounterOf(*a, *b);
  double pad = kPad;
  for (const SweepReport& sweep : claim.report->sweeps) {
    if (sweep.result != nullptr) pad += 2 * sweep.result->pad_m;
  }
  if (isApart(state) && before != nullptr && met.is_certain) {
    std::ostringstream text;
    text << "they touched on the way from where they were at " << start->stamp;
    fault(state, text.str());
  }
  if (state.state == ContactState::PASSED && met.least_m > pad) {
    std::ostringstream text;
    text << "on the way from where they were at " << start->stamp << " they came within "
         << met.least_m << " m";
    fault(state, text.str());
  }
}

// Frames are where transforms say every 5 ms, as the monitor promises; vertices move on straight
// lines in their frame.
std::optional<SmallMotion> StateJudge::motionOf(const Used& from, const Used& to) const {
  const std::int64_t length_ns = nanosecondsBetween(to.stamp, from.stamp);
  const bool stands = to.frame == "base" || length_ns == 0;
  const std::int64_t parts = stands ? 1 : std::clamp<std::int64_t>(length_ns / 5000000 + 1, 1, 200);
  SmallMotion motion{{}, {}, to.local.triangles};
  for (std::int64_t i = 0; i <= parts; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(parts);
    ros::Time stamp;
    stamp.fromNSec(from.stamp.toNSec() + length_ns * i / parts);
    const std::optional<RigidTransform> pose = i == 0       ? from.pose
                                               : i == parts ? to.pose
                                                            : world_.poseAt(to.frame, stamp);
    if (!pose) return std::nullopt;
    motion.times.push_back(part);
    motion.vertices.push_back(to.local.vertices);
    for (std::size_t k = 0; k < to.local.vertices.size(); ++k) {
      const Vec3d &begin = from.local.vertices[k], &end = to.local.vertices[k];
      motion.vertices.back()[k] = transformed(*pose, begin + (end - begin) * part);
    }
  }
  return motion;
}

void StateJudge::rememberCycle(const CycleReport& report) {
  Start start{begun_, report.header.stamp, {}};
  bool is_robots = false;
  for (const BodyStatus& body : report.bodies) {
    is_robots = is_robots || (body.triggered && body.kind == BodyKind::kLink);
    if (body.stamp.isZero() || !body.unknown_because.empty()) continue;
    const std::optional<Used> used = usedOf(body);
    if (!used) continue;
    start.bodies[body.name] = *used;
    if (used->object) world_.mesh(*used->object, used->stamp)->was_used = true;
  }
  for (const BodyStatus& body : report.bodies) {
    if (body.triggered && body.kind == BodyKind::kDeformable) starts_[body.name] = start;
  }
  if (is_robots) starts_["robot"] = start;
}

}  // namespace deformable_contact_monitor
