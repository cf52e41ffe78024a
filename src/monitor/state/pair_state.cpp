// Decides how each pair of bodies stands after one cycle.
//
// At the stamp, a pair is in CONTACT if some of its triangles touch, if a part of one body lies
// within the other, or if its distance is at most the tolerance. What was found is certain, so
// CONTACT holds even if the detection was cut off. NEAR and NONE claim that there is no contact:
// they become UNKNOWN if a contact of the pair may be missing. A pair that does not touch is NEAR
// if the detection found a nearest pair of its triangles, which it does within the margin only.
#include "monitor/state/pair_state.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "core/common/posed_body.h"
#include "core/limits.h"
#include "core/pair_geometry.h"
#include "core/rules/geometry_of_pair.h"
#include "monitor/messages/contact_messages.h"
#include "monitor/state/rejected_sides.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// The parts of one body of a pair that lie within the other one.
struct InsideParts {
  std::uint8_t which = 0;  // as ContactState::inside; 1 if each body has parts within the other
  Vec3d centroid;          // mean of the parts' own centroids [m]; zero if there are no parts

  bool any() const { return which != 0; }
};

// Finds the parts of `inner` within `outer`, which lie next to each other in the sorted list.
InsideParts partsWithin(const std::vector<InsidePart>& parts, BodyId inner, BodyId outer,
                        std::uint8_t which) {
  const auto first = std::lower_bound(parts.begin(), parts.end(), std::tie(inner, outer),
                                      [](const InsidePart& part, const auto& bodies) {
                                        return std::tie(part.inner, part.outer) < bodies;
                                      });
  InsideParts found;
  double count = 0;
  for (auto part = first; part != parts.end(); ++part) {
    if (part->inner != inner || part->outer != outer) break;
    found.centroid = found.centroid + part->centroid;
    ++count;
  }
  if (count == 0) return found;
  found.which = which;
  found.centroid = found.centroid * (1 / count);
  return found;
}

// Returns no parts if they were not looked for.
InsideParts insidePartsOf(const CycleReport& report, const MonitoredPair& pair) {
  if (report.containment == nullptr) return {};
  const std::vector<InsidePart>& parts = report.containment->parts;
  const InsideParts a_in_b = partsWithin(parts, pair.a, pair.b, 1);
  return a_in_b.any() ? a_in_b : partsWithin(parts, pair.b, pair.a, 2);
}

// Returns where the triangles of a listed pair are nearest to each other.
NearPoints pointsOf(const CycleReport& report, std::size_t contact) {
  const TrianglePair& pair = report.result->contacts[contact];
  const PosedBody a(report.scene->body(pair.body_a)), b(report.scene->body(pair.body_b));
  const float separation_m = report.result->separationM(contact);
  const PairGeometry geometry =
      geometryOf(a.triangle(pair.triangle_a), b.triangle(pair.triangle_b), separation_m);
  if (separation_m <= 0) return {geometry.point_a, geometry.point_a, Vec3f(), 0};
  return {geometry.point_a, geometry.point_b, geometry.normal, separation_m};
}

// Interprets what a detection found of one pair at the stamp. It is a view of the report, which
// must have a result.
class StampFinding {
 public:
  StampFinding(const CycleReport& report, const MonitoredPair& pair, const PairSummary& summary,
               const StateRules& rules);

  // Returns why the state is UNKNOWN; empty if it is not.
  std::string problem() const;
  // Returns whether the pair is within its margin and does not touch. There must be no problem.
  bool isNear() const;
  // Returns a lower bound of the distance that is certain [m]; 0 if there is none.
  float distanceLowM() const;
  // Returns where a pair that is in CONTACT or NEAR is nearest to each other.
  NearPoints points() const;
  // Fills in NONE, NEAR or CONTACT with its numbers. There must be no problem.
  void describe(ContactState* state) const;

 private:
  // Returns whether two triangles of the pair are known to touch.
  bool isTouching() const {
    return summary_.touches() || (nearest_ != nullptr && nearest_->distance_m == 0);
  }
  bool isWithinTolerance() const { return bounds_ && bounds_->touches(); }
  bool isContact() const { return isTouching() || inside_.any() || isWithinTolerance(); }
  // Returns whether the surfaces are apart, and one body has parts inside the other.
  bool isWithin() const { return inside_.any() && !isTouching() && !isWithinTolerance(); }
  // Returns whether the result lists all contacts of the pair.
  bool isListed() const { return !bounds_ || bounds_->bounds->is_listed; }
  // Returns whether the nearest triangles of the pair are in the list.
  bool isInList() const { return isListed() && summary_.count > 0; }
  std::string missingContacts() const;
  float distanceM() const;
  void setPlace(ContactState* state) const;

  const CycleReport& report_;
  const MonitoredPair pair_;
  const PairSummary summary_;
  const StateRules& rules_;
  const InsideParts inside_;
  std::optional<PairBounds> bounds_;
  bool is_undecided_ = false;  // the bodies' contacts are not listed, so nobody knows of the part's
  const NearestPair* nearest_;  // null if it is not known for certain
};

// A detection that was cut off may not have looked at all of a pair, unless its bounds decide the
// pair. What it found to touch does. A body has no distance from itself, so of self-contact, listed
// pairs that do not touch do not count.
StampFinding::StampFinding(const CycleReport& report, const MonitoredPair& pair,
                           const PairSummary& summary, const StateRules& rules)
    : report_(report),
      pair_(pair),
      summary_(pair.a != pair.b || summary.touches() ? summary : PairSummary()),
      rules_(rules),
      inside_(insidePartsOf(report, pair)),
      bounds_(boundsOf(report, pair, rules.tolerance_m)),
      nearest_(nearestOf(report, pair)) {
  // The bounds are those of the bodies. For a part they say something only if the bodies are apart.
  const bool is_part = pair.part_a != 0 || pair.part_b != 0;
  if (is_part && bounds_ && bounds_->decision != PairDecision::kNone) {
    is_undecided_ = !bounds_->bounds->is_listed;
    bounds_.reset();
  }
  const bool is_open =
      report.result->cut_off && !(bounds_ && bounds_->decision == PairDecision::kNear);
  if (nearest_ != nullptr && nearest_->distance_m > 0 && is_open) nearest_ = nullptr;
}

std::string StampFinding::problem() const {
  if (isContact()) return "";
  std::string missing = missingContacts();
  if (!missing.empty() || nearest_ != nullptr || !bounds_ || bounds_->isApart()) return missing;
  const std::string& why = report_.result->cut_off_because;
  return why.empty() || why == kNoTime ? "not decided in time" : why;
}

// Returns why contacts of the pair may be missing: they were not looked for, not listed, or belong
// to rejected triangles. Bounds of the pair's distance stay certain even if the detection was cut
// off.
std::string StampFinding::missingContacts() const {
  const DetectionResult& result = *report_.result;
  if (result.cut_off && !bounds_) return result.cut_off_because;
  if (is_undecided_) return kNoTime;
  if (report_.containment != nullptr && pair_.a != pair_.b &&
      !report_.containment->cut_off_because.empty()) {
    return report_.containment->cut_off_because;
  }
  if (secondsBetween(report_.now, report_.header.stamp) > rules_.max_age_s) {
    return "the cycle ended later than max_mesh_age_s after its stamp";
  }
  if (result.left_out > 0) return "contacts were left out: memory_limit_mib";
  for (const bool is_a : {true, false}) {
    const BodyStatus& body = report_.bodies.at(is_a ? pair_.a : pair_.b);
    std::string problem = rejectsProblem(
        report_, pair_, is_a, {body.rejected, body.rejected_by_part}, rules_.tolerated_rejects);
    if (!problem.empty()) return problem;
  }
  return "";
}

bool StampFinding::isNear() const {
  if (isContact()) return false;
  if (nearest_ != nullptr) return true;
  return bounds_ ? bounds_->decision == PairDecision::kNear : summary_.count > 0;
}

// The distance of a nearest pair is rounded to the nearest float32, so the next smaller one is
// certain.
float StampFinding::distanceLowM() const {
  if (inside_.any() || isTouching() || !missingContacts().empty()) return 0;
  if (nearest_ != nullptr) return std::nextafter(nearest_->distance_m, 0.F);
  return bounds_ ? bounds_->bounds->low_m : 0;
}

// Returns the distance of a pair that is NEAR. With a tolerance it may be too small, but never too
// large.
float StampFinding::distanceM() const {
  if (nearest_ != nullptr) return nearest_->distance_m;
  return isInList() ? static_cast<float>(summary_.min_separation_m) : bounds_->bounds->low_m;
}

NearPoints StampFinding::points() const {
  if (isWithin()) {
    const Vec3f middle = toFloat(inside_.centroid);
    return {middle, middle, Vec3f(), 0};
  }
  if (nearest_ != nullptr) {
    return {nearest_->point_a, nearest_->point_b, nearest_->normal, nearest_->distance_m};
  }
  if (summary_.touches() || isInList()) return pointsOf(report_, summary_.nearest);
  if (!bounds_) return {};
  const BodyDistance& witness = *bounds_->bounds;
  return {witness.point_a, witness.point_b, toFloat(bounds_->normal()), witness.low_m};
}

void StampFinding::describe(ContactState* state) const {
  state->pair_count = saturated(summary_.count);
  state->min_separation = static_cast<float>(summary_.min_separation_m);
  // If contacts may be missing, a part with a point inside may in truth cross the surface.
  state->inside = isListed() || bounds_->isApart() ? inside_.which : 0;
  if (isContact()) {
    state->state = ContactState::CONTACT;
    state->min_separation = std::min(state->min_separation, 0.F);
  } else if (isNear()) {
    state->state = ContactState::NEAR;
    state->min_separation = distanceM();
  }
  if (state->state != ContactState::NONE) setPlace(state);
}

// Sets where the pair touches or is near, and the direction from a to b.
void StampFinding::setPlace(ContactState* state) const {
  const NearPoints nearest = points();
  state->point_a = toPoint32(nearest.point_a);
  state->point_b = toPoint32(nearest.point_b);
  if (state->state == ContactState::NEAR) {
    state->normal = toPoint32(nearest.normal);
  } else if (hasGeometry(report_) && summary_.count > 0) {
    state->normal = toPoint32(report_.result->geometry[summary_.deepest].normal);
  }
  if (summary_.count > 0 && !isWithin()) {
    state->centroid = toPoint32(summary_.centroid());
    state->mean_normal = toPoint32(summary_.meanNormal());
  } else {
    state->centroid = toPoint32((toDouble(nearest.point_a) + toDouble(nearest.point_b)) * 0.5);
    state->mean_normal = toPoint32(nearest.normal);
  }
}

// Returns for each pair of bodies, and each of a part and a body, when its first contact began at
// the earliest. Contacts are sorted by bodies, so the map is searched once for each pair of bodies
// and not for each contact.
std::map<PartPair, float> firstLows(const CycleReport& report, const DetectionResult& result) {
  std::map<PartPair, float> lows;
  auto of_last = lows.end();
  for (std::size_t i = 0; i < result.first_times.size(); ++i) {
    const PartPair pair{result.contacts[i].body_a, result.contacts[i].body_b, 0, 0};
    const float low = result.first_times[i].low;
    if (of_last == lows.end() || !(of_last->first == pair)) {
      of_last = lows.try_emplace(pair, 1.F).first;
    }
    of_last->second = std::min(of_last->second, low);
    if (report.part_pairs.empty()) continue;
    forEachPartPair(report, result.contacts[i], [&](const PartPair& of_part) {
      float& kept = lows.try_emplace(of_part, 1.F).first->second;
      kept = std::min(kept, low);
    });
  }
  return lows;
}

// Returns the nearest pair of these two pieces; null if there is none within the margin.
const NearestPair* nearestOfParts(const DetectionResult& result, const PartPair& parts) {
  const std::vector<NearestOfParts>& all = result.nearest_parts;
  const auto found = std::lower_bound(
      all.begin(), all.end(), parts,
      [](const NearestOfParts& one, const PartPair& of) { return one.parts < of; });
  return found != all.end() && found->parts == parts ? &found->nearest : nullptr;
}

// Returns the nearest pair of a part of one body and all of the other one.
const NearestPair* nearestOfPart(const CycleReport& report, const MonitoredPair& pair) {
  const NearestPair* best = nullptr;
  for (const PartId piece_a : piecesOf(report.bodies.at(pair.a), pair.part_a)) {
    for (const PartId piece_b : piecesOf(report.bodies.at(pair.b), pair.part_b)) {
      const NearestPair* const one =
          nearestOfParts(*report.result, {pair.a, pair.b, piece_a, piece_b});
      const auto key = [](const NearestPair& nearest) {
        return std::make_pair(nearest.distance_m, nearest.pair);
      };
      if (one != nullptr && (best == nullptr || key(*one) < key(*best))) best = one;
    }
  }
  return best;
}

}  // namespace

StateRules stateRules(const MonitorParameters& parameters) {
  StateRules rules;
  rules.debounce_on_cycles = parameters.debounce_on_cycles;
  rules.debounce_off_cycles = parameters.debounce_off_cycles;
  rules.max_age_s = parameters.max_mesh_age_s;
  rules.tolerated_rejects = parameters.tolerated_rejects;
  rules.since_survives_s = parameters.since_survives_s;
  rules.tolerance_m = parameters.detector.tolerance_m;
  return rules;
}

Vec3d PairBounds::normal() const {
  constexpr double kRounding = 0x1p-20;  // of the points, relative to their largest coordinate
  const Vec3d a = toDouble(bounds->point_a), b = toDouble(bounds->point_b);
  double largest = 0;
  for (const Vec3d& v : {a, b}) {
    largest = std::max({largest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  }
  const Vec3d way = b - a;
  const double length = std::sqrt(dot(way, way));
  if (bounds->high_m == 0 || length <= kRounding * largest) return {};
  return way * (1 / length);
}

std::optional<PairBounds> boundsOf(const CycleReport& report, const MonitoredPair& pair,
                                   float tolerance_m) {
  if (report.result == nullptr) return std::nullopt;
  const std::vector<BodyDistance>& all = report.result->distances;
  const auto found = std::lower_bound(
      all.begin(), all.end(), pair, [](const BodyDistance& one, const MonitoredPair& of) {
        return std::tie(one.body_a, one.body_b) < std::tie(of.a, of.b);
      });
  if (found == all.end() || found->body_a != pair.a || found->body_b != pair.b) {
    return std::nullopt;
  }
  return PairBounds{&*found, decide(*found, *report.scene, tolerance_m)};
}

const NearestPair* nearestOf(const CycleReport& report, const MonitoredPair& pair) {
  if (report.result == nullptr) return nullptr;
  if (pair.part_a != 0 || pair.part_b != 0) return nearestOfPart(report, pair);
  const std::vector<NearestPair>& all = report.result->nearest;
  NearestPair key;
  key.pair = {pair.a, 0, pair.b, 0};
  const auto found = std::lower_bound(all.begin(), all.end(), key);
  const bool is_there =
      found != all.end() && found->pair.body_a == pair.a && found->pair.body_b == pair.b;
  return is_there ? &*found : nullptr;
}

// The nearest pairs and the bounds say all that is needed, so contacts need not be summed up.
std::optional<NearPoints> nearPoints(const CycleReport& report, const MonitoredPair& pair,
                                     const StateRules& rules) {
  if (report.result == nullptr || pair.allowed) return std::nullopt;
  if (!isOfCycle(report.bodies, pair) || !bodyProblem(report, pair).empty()) return std::nullopt;
  const StampFinding finding(report, pair, PairSummary(), rules);
  if (!finding.problem().empty() || !finding.isNear()) return std::nullopt;
  return finding.points();
}

std::string bodyProblem(const BodyStatus& body, PartId part) {
  if (!body.unknown_because.empty()) return body.name + ": " + body.unknown_because;
  return part == 0 || part == body.parts->heldPart() ? "" : body.parts->problem;
}

std::string bodyProblem(const CycleReport& report, const MonitoredPair& pair) {
  const std::string of_a = bodyProblem(report.bodies.at(pair.a), pair.part_a);
  return of_a.empty() ? bodyProblem(report.bodies.at(pair.b), pair.part_b) : of_a;
}

void IntervalFinding::setPassed(ContactState* state) const {
  state->state = ContactState::PASSED;
  state->pair_count = saturated(passed.count);
  state->min_separation = 0;
  state->point_a = state->point_b = state->normal = geometry_msgs::Point32();
  state->centroid = toPoint32(passed.centroid());
  state->mean_normal = toPoint32(passed.meanNormal());
}

PairStates::PairStates(const CycleReport& report, const StateRules& rules)
    : report_(report), rules_(rules), at_stamp_(report, report.result.get()) {
  for (const SweepReport& sweep : report.sweeps) {
    for (const MonitoredPair& pair : sweep.pairs) {
      interval_of_[{pair.a, pair.b}] = intervals_.size();
    }
    const DetectionResult* const result =
        sweep.result == nullptr ? nullptr : &sweep.result->detection;
    intervals_.push_back({&sweep, PairSummaries(report, result), {}});
    if (result != nullptr) intervals_.back().first_low = firstLows(report, *result);
  }
}

ContactState PairStates::atStamp(const MonitoredPair& pair) const {
  ContactState state;
  state.body_a = nameOf(report_.bodies.at(pair.a), pair.part_a);
  state.body_b = nameOf(report_.bodies.at(pair.b), pair.part_b);
  state.stamp = report_.header.stamp;
  state.reason = bodyProblem(report_, pair);
  if (state.reason.empty() && report_.result == nullptr) state.reason = "no detection ran";
  if (state.reason.empty()) {
    const StampFinding finding(report_, pair, at_stamp_.of(pair), rules_);
    state.reason = finding.problem();
    state.distance_low = finding.distanceLowM();
    if (state.reason.empty()) finding.describe(&state);
  }
  if (!state.reason.empty()) state.state = ContactState::UNKNOWN;
  return state;
}

IntervalFinding PairStates::inInterval(const MonitoredPair& pair) const {
  IntervalFinding finding;
  const auto found = interval_of_.find({pair.a, pair.b});
  if (found == interval_of_.end()) return finding;
  const Interval& interval = intervals_[found->second];
  for (const BodyId id : {pair.a, pair.b}) {
    const std::string& skipped = interval.sweep->bodies[id].skipped;
    if (skipped.empty()) continue;
    finding.has_interval = false;
    finding.problem = report_.bodies[id].name + ": no step from the previous cycle: " + skipped;
    return finding;
  }
  finding.from = interval.sweep->from;
  finding.passed = interval.touched.of(pair);
  if (finding.touched()) {
    const auto low = interval.first_low.find(partKey(pair));
    finding.first_low = low == interval.first_low.end() ? 0 : low->second;
  } else {
    finding.problem = intervalProblem(*interval.sweep, pair);
  }
  return finding;
}

// Returns why contacts of the pair may be missing in its interval; empty if none is missing.
std::string PairStates::intervalProblem(const SweepReport& sweep, const MonitoredPair& pair) const {
  if (sweep.result == nullptr) return "the step's detection failed: " + sweep.problem;
  const DetectionResult& result = sweep.result->detection;
  if (result.cut_off) return "in the step: " + result.cut_off_because;
  if (result.left_out > 0) return "in the step, contacts were left out: memory_limit_mib";
  const std::vector<BodyId>& outlying = sweep.result->outlying;
  for (const BodyId id : {pair.a, pair.b}) {
    if (std::find(outlying.begin(), outlying.end(), id) != outlying.end()) {
      return report_.bodies[id].name + ": in the step, it has vertices too far off to be followed";
    }
    const StepBody& body = sweep.bodies[id];
    const Rejects rejects{body.rejected, body.rejected_by_part, "in the step, "};
    std::string problem =
        rejectsProblem(report_, pair, id == pair.a, rejects, rules_.tolerated_rejects);
    if (!problem.empty()) return problem;
  }
  return "";
}

}  // namespace deformable_contact_monitor
