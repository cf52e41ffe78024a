// What a cycle's detection says of one pair of bodies.
#include "monitor/state/pair_finding.h"

#include <algorithm>

#include "monitor/messages/contact_messages.h"
#include "monitor/point32.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {

PairFinding::PairFinding(const CycleReport& report, const MonitoredPair& pair,
                         const PairSummary& summary, const StateRules& rules)
    : report_(report),
      pair_(pair),
      summary_(summary),
      rules_(rules),
      inside_(insidePartsOf(report, pair)),
      distance_(distanceOf(report, pair, rules.tolerance_m)) {}

bool PairFinding::isContact() const {
  return summary_.touches() || inside_.any() || (distance_ && distance_->touches());
}

std::string PairFinding::problem() const {
  if (report_.result == nullptr) return "no detection ran";
  if (isContact()) return "";
  const std::string problem = problemOfResult();
  if (!problem.empty() || !distance_ || distance_->isApart()) return problem;
  const std::string& why = report_.result->cut_off_because;
  return why.empty() || why == kNoTime ? "not decided in time" : why;
}

// The pair's contacts may be among those that are not listed, that were not looked at, or of
// triangles that took no part. What is certain of its distance stays so however the cycle ended.
std::string PairFinding::problemOfResult() const {
  const DetectionResult& result = *report_.result;
  if (result.cut_off && !distance_) return result.cut_off_because;
  if (report_.containment != nullptr && pair_.a != pair_.b &&
      !report_.containment->cut_off_because.empty()) {
    return report_.containment->cut_off_because;
  }
  if (secondsBetween(report_.now, report_.header.stamp) > rules_.max_age_s) {
    return "the cycle ended later than max_mesh_age_s after its stamp";
  }
  if (result.left_out > 0) return "contacts were left out: memory_limit_mib";
  return rejectedProblem();
}

std::string PairFinding::rejectedProblem() const {
  for (const BodyId id : {pair_.a, pair_.b}) {
    const BodyStatus& body = report_.bodies.at(id);
    const std::size_t triangles = report_.scene->body(id).mesh.triangleCount();
    if (static_cast<double>(body.rejected) <=
        rules_.tolerated_rejects * static_cast<double>(triangles)) {
      continue;
    }
    return body.name + ": " + std::to_string(body.rejected) + " of " + std::to_string(triangles) +
           " triangles have a vertex that is not finite (tolerated_rejects)";
  }
  return "";
}

float PairFinding::distanceLowM() const {
  const bool is_certain = distance_ && !inside_.any() && problemOfResult().empty();
  return is_certain ? distance_->bounds->low_m : 0;
}

ContactState PairFinding::state() const {
  ContactState state;
  state.body_a = report_.bodies.at(pair_.a).name;
  state.body_b = report_.bodies.at(pair_.b).name;
  state.stamp = report_.header.stamp;
  state.pair_count = saturated(summary_.count);
  state.min_separation = static_cast<float>(summary_.min_separation_m);
  state.distance_low = distanceLowM();
  // Where not all contacts are known, what has a point inside may cross the surface.
  state.inside = isListed() || distance_->isApart() ? inside_.which : 0;
  if (isContact()) {
    state.state = ContactState::CONTACT;
    state.min_separation = std::min(state.min_separation, 0.F);
  } else if (distance_ && distance_->decision == PairDecision::kNear) {
    state.state = ContactState::NEAR;
    if (!isListed()) state.min_separation = distance_->bounds->low_m;
  } else if (summary_.count > 0) {
    state.state = ContactState::NEAR;
  }
  if (state.state != ContactState::NONE) setPlace(&state);
  return state;
}

// Where it is, and which way b is from a.
void PairFinding::setPlace(ContactState* state) const {
  const bool is_within =
      inside_.any() && !summary_.touches() && !(distance_ && distance_->touches());
  if (is_within) {
    state->centroid = toPoint32(inside_.centroid);
  } else if (summary_.count > 0 || !distance_) {
    state->centroid = toPoint32(summary_.centroid());
    state->mean_normal = toPoint32(summary_.meanNormal());
  } else {
    state->centroid = toPoint32(distance_->centroid());
    state->mean_normal = toPoint32(distance_->normal());
  }
}

}  // namespace deformable_contact_monitor
