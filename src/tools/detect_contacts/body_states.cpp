// Decides and prints the state of each pair of bodies. The core's decide() turns bounds of a
// distance into a state. A result without bounds, as from exact detection, is first turned into
// bounds from its list of contacts.
#include "tools/detect_contacts/body_states.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

// Returns the bounds of a pair's distance that follow from the list of contacts: the nearest
// contact gives the upper bound and the witness. If the result has no separations, all contacts
// intersect, at distance 0. The lower bound stays 0.
BodyDistance listedDistance(const DetectionResult& result, BodyId a, BodyId b) {
  BodyDistance distance;
  distance.body_a = a;
  distance.body_b = b;
  distance.is_listed = !result.cut_off && result.left_out == 0;
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    const TrianglePair& contact = result.contacts[i];
    if (contact.body_a != a || contact.body_b != b) continue;
    ++distance.contact_count;
    const float high_m = result.separations_m.empty() ? 0 : result.separations_m[i];
    if (high_m >= distance.high_m) continue;
    distance.high_m = high_m;
    distance.witness = contact;
  }
  return distance;
}

Json point(const Vec3f& p) { return {p.x, p.y, p.z}; }

}  // namespace

// The margin of a pair is the larger one of its two bodies.
std::vector<BodyState> bodyStates(const Scene& scene, const DetectionResult& result,
                                  float tolerance_m) {
  // Exact detection has no bounds, so they are made from its list.
  std::vector<BodyDistance> distances = result.distances;
  if (distances.empty()) {
    for (const auto& [a, b] : scene.enabledPairs()) {
      if (a != b) distances.push_back(listedDistance(result, a, b));
    }
  }
  // The core decides, so the tool and the node report the same states.
  std::vector<BodyState> states;
  for (const BodyDistance& distance : distances) {
    const float margin_m =
        std::max(scene.body(distance.body_a).margin_m, scene.body(distance.body_b).margin_m);
    states.push_back({distance, decide(distance, margin_m, tolerance_m)});
  }
  return states;
}

// Names at most kShown pairs, because a scene of many bodies has many pairs.
std::string bodyStateLines(const Scene& scene, const std::vector<BodyState>& states) {
  constexpr std::size_t kShown = 20;
  std::string text;
  for (std::size_t i = 0; i < std::min(states.size(), kShown); ++i) {
    const BodyDistance& d = states[i].distance;
    char range[120];
    if (std::isinf(d.high_m)) {
      std::snprintf(range, sizeof range, "at least %.6g apart", d.low_m);
    } else {
      std::snprintf(range, sizeof range, "%.6g to %.6g apart, by triangles %u and %u", d.low_m,
                    d.high_m, d.witness.triangle_a, d.witness.triangle_b);
    }
    text += "  " + scene.body(d.body_a).name + " with " + scene.body(d.body_b).name + ": " +
            toString(states[i].decision) + ", " + range + "\n";
  }
  if (states.size() <= kShown) return text;
  return text + "  and " + std::to_string(states.size() - kShown) + " more pairs of bodies\n";
}

// An infinite upper bound means that no witness is known. JSON has no infinity, so it becomes null.
Json bodyStatesJson(const std::vector<BodyState>& states) {
  Json json = Json::array();
  for (const BodyState& state : states) {
    const BodyDistance& d = state.distance;
    const bool has_witness = !std::isinf(d.high_m);
    json.push_back(
        {{"bodies", {d.body_a, d.body_b}},
         {"state", toString(state.decision)},
         {"distance_low", d.low_m},
         {"distance_high", has_witness ? Json(d.high_m) : Json()},
         {"witness", has_witness ? Json{d.witness.triangle_a, d.witness.triangle_b} : Json()},
         {"points", has_witness ? Json{point(d.point_a), point(d.point_b)} : Json()},
         {"listed", d.is_listed},
         {"contacts", d.contact_count}});
  }
  return json;
}

}  // namespace deformable_contact_monitor
