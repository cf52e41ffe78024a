#include "core/bounds/exact_distances.h"

#include <cmath>
#include <cstddef>
#include <map>

#include "core/bounds/distance_rounding.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

// Counts a contact, and makes it the pair's witness if it is the nearest so far. Separations are
// rounded to the nearest float32, so the next greater one is an upper bound.
void addContact(const DetectionResult& exact, std::size_t i, BodyDistance& distance) {
  ++distance.contact_count;
  const float separation_m = exact.separationM(i);
  const float high_m = separation_m > 0 ? std::nextafter(separation_m, INFINITY) : 0;
  if (high_m >= distance.high_m) return;
  distance.high_m = high_m;
  distance.witness = exact.contacts[i];
  if (exact.geometry.size() == exact.contacts.size()) {
    distance.point_a = exact.geometry[i].point_a;
    distance.point_b = high_m > 0 ? exact.geometry[i].point_b : exact.geometry[i].point_a;
  }
}

// Makes a nearest pair the pair's witness. Its distance is rounded to the nearest float32, so the
// next greater one is an upper bound.
void addNearest(const NearestPair& nearest, BodyDistance& distance) {
  distance.witness = nearest.pair;
  distance.high_m = nearest.distance_m > 0 ? std::nextafter(nearest.distance_m, INFINITY) : 0;
  distance.low_m = roundedDown(nearest.distance_m * (1 - 1e-6));
  distance.point_a = nearest.point_a;
  distance.point_b = nearest.point_b;
}

}  // namespace

std::vector<BodyDistance> distancesOf(const Scene& scene, const std::vector<IdPair>& pairs,
                                      const DetectionResult& exact, bool wants_nearest,
                                      bool is_searched) {
  std::map<IdPair, BodyDistance> distances;
  const bool all_listed = exact.guaranteed && !exact.cut_off && exact.left_out == 0;
  for (const IdPair& pair : pairs) {
    if (pair.first == pair.second) continue;
    BodyDistance& distance = distances[pair];
    distance.body_a = pair.first;
    distance.body_b = pair.second;
    distance.is_listed = all_listed;
    distance.is_exact = is_searched;
  }
  auto found = distances.end();  // contacts of one pair of bodies mostly follow each other
  for (std::size_t i = 0; i < exact.contacts.size(); ++i) {
    const IdPair pair{exact.contacts[i].body_a, exact.contacts[i].body_b};
    if (found == distances.end() || found->first != pair) found = distances.find(pair);
    if (found != distances.end()) addContact(exact, i, found->second);
  }
  for (const NearestPair& nearest : exact.nearest) {
    addNearest(nearest, distances.at({nearest.pair.body_a, nearest.pair.body_b}));
  }
  const bool all_known = wants_nearest ? is_searched : all_listed;
  std::vector<BodyDistance> list;
  for (auto& [pair, distance] : distances) {
    if (all_known && distance.high_m == INFINITY) {
      distance.low_m =
          pairMargin(scene.body(pair.first).margin_m, scene.body(pair.second).margin_m);
    } else if (all_known) {
      // Separations are rounded to the nearest float32.
      distance.low_m = roundedDown(distance.high_m * (1 - 1e-6));
    }
    list.push_back(distance);
  }
  return list;
}

void giveDistances(const Scene& scene, const Options& options, bool is_searched,
                   DetectionResult* result) {
  const bool are_wanted = options.tolerance_m > 0 || (options.nearest && result->cut_off);
  if (are_wanted && options.motion == Motion::kInstant) {
    result->distances = distancesOf(scene, scene.enabledPairs(), *result, true, is_searched);
  }
  if (!options.nearest) result->nearest.clear();
}

}  // namespace deformable_contact_monitor
