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

bool isBefore(const NearestPair& x, const NearestPair& y) {
  return IdPair(x.pair.body_a, x.pair.body_b) < IdPair(y.pair.body_a, y.pair.body_b);
}

// Returns the enabled pairs of two bodies that are not in `found`, which is sorted.
std::vector<IdPair> otherPairs(const Scene& scene, const std::vector<NearestPair>& found) {
  std::vector<IdPair> others;
  auto next = found.begin();
  for (const IdPair& pair : scene.enabledPairs()) {
    if (pair.first == pair.second) continue;
    if (next != found.end() && IdPair(next->pair.body_a, next->pair.body_b) == pair) {
      ++next;
    } else {
      others.push_back(pair);
    }
  }
  return others;
}

}  // namespace

void DistanceSearch::find(const Scene& scene, const Options& options, const CycleLimit& limit,
                          DetectionResult& result) {
  if (!options.nearest || limit.over()) return;
  SearchGoal goal;
  goal.nearest = true;
  goal.are_apart = tellsWhatTouches(options, result);
  if (goal.are_apart) result.nearest = touchingPairs(scene, result);
  const std::vector<IdPair> pairs = otherPairs(scene, result.nearest);
  std::vector<std::shared_ptr<const Tiling>> tilings(scene.bodyCount());
  std::vector<bool> is_new(scene.bodyCount(), true);
  for (const auto& [a, b] : pairs) {
    for (const BodyId id : {a, b}) {
      if (is_new[id]) tilings[id] = tilings_->of(scene.body(id));
      is_new[id] = false;
    }
  }
  rounds_.begin(scene, pairs, tilings, goal, limit);
  rounds_.decide(limit, SteadyTime::max());
  const std::vector<NearestPair> apart = rounds_.nearest(scene);
  const auto touching = static_cast<std::ptrdiff_t>(result.nearest.size());
  result.nearest.insert(result.nearest.end(), apart.begin(), apart.end());
  std::inplace_merge(result.nearest.begin(), result.nearest.begin() + touching,
                     result.nearest.end(), isBefore);
}

}  // namespace deformable_contact_monitor
