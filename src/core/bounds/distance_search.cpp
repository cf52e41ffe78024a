// Searches the pairs of bodies that do not touch. Tiles by surface are made on a thread of the
// tiling cache. Until they are there, and for topologies that change all the time, tiles are runs
// of triangles.
#include "core/bounds/distance_search.h"

#include <algorithm>
#include <cstddef>

#include "core/bounds/pair_search.h"
#include "core/common/contact_geometry.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

// Returns whether the list of contacts has all pairs of triangles that intersect now, and no others
// that count as touching.
bool tellsWhatTouches(const Options& options, const DetectionResult& result) {
  return options.motion == Motion::kInstant && options.predicates == Predicates::kExact &&
         options.overlap == 1 && !result.cut_off && result.left_out == 0;
}

// Returns the searches of a scene whose result is not in `found` or `found_parts`, which are
// sorted.
std::vector<SearchedPair> otherSearches(const Scene& scene, bool by_part,
                                        const std::vector<NearestPair>& found,
                                        const std::vector<NearestOfParts>& found_parts) {
  std::vector<IdPair> pairs;
  for (const IdPair& pair : scene.enabledPairs()) {
    if (pair.first != pair.second) pairs.push_back(pair);
  }
  std::vector<SearchedPair> searches = searchesOf(scene, pairs, by_part);
  const auto isFound = [&](const SearchedPair& search) {
    if (search.parts) {
      const NearestOfParts key{*search.parts, NearestPair()};
      return std::binary_search(found_parts.begin(), found_parts.end(), key);
    }
    NearestPair key;
    key.pair = {search.a, 0, search.b, 0};
    return std::binary_search(found.begin(), found.end(), key);
  };
  searches.erase(std::remove_if(searches.begin(), searches.end(), isFound), searches.end());
  return searches;
}

}  // namespace

void DistanceSearch::find(const Scene& scene, const Options& options, const CycleLimit& limit,
                          PairRounds& rounds, DetectionResult& result) {
  if (!options.nearest || limit.over()) return;
  SearchGoal goal;
  goal.nearest = true;
  goal.are_apart = tellsWhatTouches(options, result);
  if (goal.are_apart) {
    result.nearest = touchingPairs(scene, result);
    if (options.nearest_by_part) result.nearest_parts = touchingParts(scene, result);
  }
  const std::vector<SearchedPair> searches =
      otherSearches(scene, options.nearest_by_part, result.nearest, result.nearest_parts);
  std::vector<std::shared_ptr<const Tiling>> tilings(scene.bodyCount());
  std::vector<bool> is_new(scene.bodyCount(), true);
  for (const SearchedPair& search : searches) {
    for (const BodyId id : {search.a, search.b}) {
      if (is_new[id]) tilings[id] = tilings_->of(scene.body(id));
      is_new[id] = false;
    }
  }
  rounds.swapLast(last_);
  rounds.begin(scene, searches, tilings, goal, limit);
  rounds.decide(limit, SteadyTime::max());
  rounds.addNearest(scene, result);
  rounds.swapLast(last_);
}

}  // namespace deformable_contact_monitor
