// How pairs of bodies stand, within a tolerance and a budget.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/body_distance.h"
#include "core/detector.h"

namespace deformable_contact_monitor {

struct BodyState {
  BodyDistance distance;
  PairDecision decision = PairDecision::kOpen;
};

// Of each enabled pair of two bodies, ascending. Where the detection looked at no bounds, by the
// contacts that it lists; then a witness's points are zero.
std::vector<BodyState> bodyStates(const Scene& scene, const DetectionResult& result,
                                  float tolerance_m);

// A line for each, of the first 20.
std::string bodyStateLines(const Scene& scene, const std::vector<BodyState>& states);

// [{bodies, state, distance_low, distance_high, witness, points, listed, contacts}]; null: not
// known.
nlohmann::json bodyStatesJson(const std::vector<BodyState>& states);

}  // namespace deformable_contact_monitor
