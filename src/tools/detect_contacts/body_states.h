// The state of each pair of bodies (NONE, NEAR, CONTACT) for --tolerance-m and --budget-ms.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/body_distance.h"
#include "core/detector.h"

namespace deformable_contact_monitor {

// The bounds of a pair's distance, in the meshes' unit, and the state that follows from them.
struct BodyState {
  BodyDistance distance;
  PairDecision decision = PairDecision::kOpen;
};

// Returns the state of each enabled pair of two bodies, ascending. If the result has no bounds
// (DetectionResult::distances), the listed contacts decide, and the points of a witness are zero.
std::vector<BodyState> bodyStates(const Scene& scene, const DetectionResult& result,
                                  float tolerance_m);

// Returns a line for each of the first 20 pairs: the names of the bodies, the state, and the bounds
// of the distance with the witness.
std::string bodyStateLines(const Scene& scene, const std::vector<BodyState>& states);

// Returns [{bodies, state, distance_low, distance_high, witness, points, listed, contacts}].
// Unknown values are null.
nlohmann::json bodyStatesJson(const std::vector<BodyState>& states);

}  // namespace deformable_contact_monitor
