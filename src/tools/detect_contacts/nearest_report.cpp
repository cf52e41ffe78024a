// Writes distances of bodies as lines, as JSON and for people. A pair that is not decided is never
// written as if it were.
#include "tools/detect_contacts/nearest_report.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/body_distance.h"
#include "core/common/rejected_bodies.h"
#include "core/vector3.h"
#include "tools/common/command_line.h"
#include "tools/common/formatted.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;
using Entry = NearestBodies::Entry;

Json coordinates(const Vec3f& p) { return {p.x, p.y, p.z}; }

// Returns the unit vector between two points, or zero if they are equal.
Vec3f direction(const Vec3f& from, const Vec3f& to) {
  const Vec3d way = toDouble(to) - toDouble(from);
  const double size = length(way);
  if (!(size > 0)) return Vec3f{0, 0, 0};
  return Vec3f{static_cast<float>(way.x / size), static_cast<float>(way.y / size),
               static_cast<float>(way.z / size)};
}

// Returns the entry of a pair that was decided by bounds: its witness, with the upper bound.
Entry boundOf(const BodyDistance& distance) {
  NearestPair nearest;
  nearest.pair = distance.witness;
  nearest.distance_m = distance.high_m;
  nearest.point_a = distance.point_a;
  nearest.point_b = distance.point_b;
  nearest.normal = direction(distance.point_a, distance.point_b);
  return {nearest, false};
}

}  // namespace

std::string firstPairs(std::size_t count, const std::function<std::string(std::size_t)>& line) {
  constexpr std::size_t kShown = 20;
  std::string text;
  for (std::size_t i = 0; i < std::min(count, kShown); ++i) text += "  " + line(i) + "\n";
  if (count <= kShown) return text;
  return text + "  and " + std::to_string(count - kShown) + " more pairs of bodies\n";
}

// The exact search is preferred; bounds fill in for pairs that it did not look at.
NearestBodies nearestBodies(const Scene& scene, const DetectionResult& result, float tolerance_m) {
  const RejectedBodies rejected(scene, Motion::kInstant, result.counters.rejected);
  std::map<std::pair<BodyId, BodyId>, Entry> found;
  for (const NearestPair& nearest : result.nearest) {
    found[{nearest.pair.body_a, nearest.pair.body_b}] = Entry{nearest, true};
  }
  NearestBodies bodies;
  std::map<std::pair<BodyId, BodyId>, const BodyDistance*> bounds;
  for (const BodyDistance& distance : result.distances) {
    bounds[{distance.body_a, distance.body_b}] = &distance;
  }
  for (const auto& pair : scene.enabledPairs()) {
    if (pair.first == pair.second || found.count(pair) > 0) continue;
    const bool has_rejected = rejected.hasOneOf(pair.first, pair.second);
    const auto bound = bounds.find(pair);
    if (bound == bounds.end()) {
      bodies.open_pairs += result.cut_off || has_rejected ? 1 : 0;
      continue;
    }
    const PairDecision decision = decide(*bound->second, scene, tolerance_m);
    const bool is_apart = decision == PairDecision::kNone;
    if (!is_apart && tolerance_m > 0 && decision != PairDecision::kOpen) {
      found[pair] = boundOf(*bound->second);
    } else {
      bodies.open_pairs += is_apart && !has_rejected ? 0 : 1;
    }
  }
  for (auto& [pair, entry] : found) {
    // Bodies that touch are at distance 0 whatever else there is.
    entry.has_rejected = entry.nearest.distance_m > 0 && rejected.hasOneOf(pair.first, pair.second);
    entry.is_exact = entry.is_exact && !entry.has_rejected;
    bodies.entries.push_back(entry);
  }
  return bodies;
}

std::string nearestLines(const NearestBodies& bodies) {
  std::string text;
  for (const Entry& entry : bodies.entries) {
    const TrianglePair& pair = entry.nearest.pair;
    text += formatted("%u %u %u %u %.9g\n", pair.body_a, pair.triangle_a, pair.body_b,
                      pair.triangle_b, entry.nearest.distance_m);
  }
  return text;
}

Json nearestJson(const NearestBodies& bodies) {
  Json json = Json::array();
  for (const Entry& entry : bodies.entries) {
    const NearestPair& nearest = entry.nearest;
    json.push_back({{"bodies", {nearest.pair.body_a, nearest.pair.body_b}},
                    {"triangles", {nearest.pair.triangle_a, nearest.pair.triangle_b}},
                    {"distance", nearest.distance_m},
                    {"exact", entry.is_exact},
                    {"points", {coordinates(nearest.point_a), coordinates(nearest.point_b)}},
                    {"normal", coordinates(nearest.normal)}});
  }
  return json;
}

std::string nearestSummary(const Scene& scene, const NearestBodies& bodies) {
  const std::size_t count = bodies.entries.size();
  return "pairs of bodies within the margin: " + std::to_string(count) + "\n" +
         firstPairs(count, [&](std::size_t i) {
           const NearestPair& nearest = bodies.entries[i].nearest;
           const std::string apart = formatted(
               "%s%.6g apart, by triangles %u and %u", bodies.entries[i].is_exact ? "" : "at most ",
               nearest.distance_m, nearest.pair.triangle_a, nearest.pair.triangle_b);
           return scene.body(nearest.pair.body_a).name + " with " +
                  scene.body(nearest.pair.body_b).name + ": " + apart;
         });
}

std::vector<std::string> nearestNotes(const NearestBodies& bodies, float tolerance_m) {
  std::vector<std::string> notes;
  if (bodies.open_pairs > 0) {
    notes.push_back(std::to_string(bodies.open_pairs) +
                    " pairs of bodies are not decided, so --nearest does not list them");
  }
  const auto bounds =
      std::count_if(bodies.entries.begin(), bodies.entries.end(),
                    [](const Entry& entry) { return !entry.is_exact && !entry.has_rejected; });
  if (bounds > 0) {
    notes.push_back(std::to_string(bounds) +
                    " distances of --nearest are upper bounds, too large by at most " +
                    toText(tolerance_m));
  }
  const auto rejected = std::count_if(bodies.entries.begin(), bodies.entries.end(),
                                      [](const Entry& entry) { return entry.has_rejected; });
  if (rejected > 0) {
    notes.push_back(std::to_string(rejected) +
                    " distances of --nearest are upper bounds, because of triangles that took no "
                    "part");
  }
  return notes;
}

}  // namespace deformable_contact_monitor
