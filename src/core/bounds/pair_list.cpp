#include "core/bounds/pair_list.h"

#include <chrono>

#include "core/bounds/distance_rounding.h"
#include "core/predicates/narrow_phase.h"

namespace deformable_contact_monitor {

bool PairList::isTime(const CycleLimit& limit) const {
  constexpr std::chrono::nanoseconds kEach(200);  // to sort a contact and to merge it
  if (limit.over()) return true;
  if (until_ == SteadyTime::max()) return false;
  const auto left = until_ - std::chrono::steady_clock::now();
  return left < kEach * static_cast<std::int64_t>(all_found_.load(std::memory_order_relaxed));
}

bool PairList::find(const BodyPair& bodies, const CycleLimit& limit) {
  constexpr std::size_t kLook = 16;
  const double needed_m = beyond(bodies.margin_m);
  for (std::size_t r = 0; r < bodies.a->regions().size(); ++r) {
    if (r % kLook == 0 && isTime(limit)) return false;
    regions_.clear();
    nearRegions(*bodies.a, r, *bodies.b, needed_m, regions_);
    for (const NearParts& regions : regions_) {
      if (!addRegions(bodies, regions, limit)) return false;
    }
  }
  return true;
}

bool PairList::addRegions(const BodyPair& bodies, const NearParts& regions,
                          const CycleLimit& limit) {
  if (isTime(limit)) return false;
  nearTiles(*bodies.a, regions.a, *bodies.b, regions.b, beyond(bodies.margin_m), tiles_);
  for (const NearParts& tiles : tiles_) {
    if (!addTiles(bodies, tiles, limit)) return false;
  }
  return true;
}

bool PairList::addTiles(const BodyPair& bodies, const NearParts& tiles, const CycleLimit& limit) {
  constexpr std::size_t kLook = 64;  // some 10 us
  const PosedTile &a = bodies.a->tile(tiles.a), &b = bodies.b->tile(tiles.b);
  nearTriangles(a, b, beyond(bodies.margin_m), triangles_);
  if (isTime(limit)) return false;
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const NearTriangles& near = triangles_[i];
    const Triangle hull_a = a.posed(near.a), hull_b = b.posed(near.b);
    PairFacts facts;
    facts.margin_m = bodies.margin_m;
    if (isCandidate(hull_a, hull_b, facts)) {
      PredicateState state{Predicates::kExact};
      const Verdict verdict = candidateVerdict(hull_a, hull_b, facts, state);
      if (verdict.contact) {
        contacts_.push_back({{bodies.a_id, a.triangle[near.a], bodies.b_id, b.triangle[near.b]},
                             verdict.separation_m});
        all_found_.fetch_add(1, std::memory_order_relaxed);
      }
    }
    if ((i + 1) % kLook == 0 && isTime(limit)) return false;
  }
  return true;
}

}  // namespace deformable_contact_monitor
