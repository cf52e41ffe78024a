// Searches all pairs of a cycle, and then lists their contacts. Threads share the pairs. If there
// is a deadline, each open pair gets a short turn in each round, so that one hard pair cannot take
// the time of all others.
#include "core/bounds/pair_rounds.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>

#include "core/bounds/distance_rounding.h"
#include "core/bounds/near_parts.h"
#include "core/common/contact_geometry.h"
#include "core/common/parallel.h"
#include "core/predicates/narrow_phase.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

// Lists all contacts of one pair of bodies, tile by tile. It is used by one thread.
class ContactList {
 public:
  // The contacts of all lists together must be sorted before `until`. The lists count them in
  // `all_found`.
  ContactList(const BodyPair& bodies, const CycleLimit& limit, SteadyTime until,
              std::atomic<std::size_t>& all_found)
      : bodies_(bodies),
        needed_m_(beyond(bodies.margin_m)),
        limit_(limit),
        until_(until),
        all_found_(all_found) {}

  // Finds all contacts of the pair, as exact detectors would, in any order, each once. Returns
  // false if the limit or the time ended it before that.
  bool find() {
    constexpr std::size_t kLook = 16;
    for (std::size_t r = 0; r < bodies_.a->regions().size(); ++r) {
      if (r % kLook == 0 && isTime()) return false;
      regions_.clear();
      nearRegions(*bodies_.a, r, *bodies_.b, needed_m_, regions_);
      for (const NearParts& regions : regions_) {
        if (!bodies_.mayCount(bodies_.a->partOfRegion(regions.a),
                              bodies_.b->partOfRegion(regions.b))) {
          continue;
        }
        if (!addRegions(regions)) return false;
      }
    }
    return true;
  }

  std::vector<ListedContact> takeContacts() { return std::move(contacts_); }

 private:
  // Returns whether to stop: the limit is over, or the time that is left is needed to sort and
  // merge the contacts found so far.
  bool isTime() const {
    constexpr std::chrono::nanoseconds kEach(200);  // to sort a contact and to merge it
    if (limit_.over()) return true;
    if (until_ == SteadyTime::max()) return false;
    const auto left = until_ - std::chrono::steady_clock::now();
    return left < kEach * static_cast<std::int64_t>(all_found_.load(std::memory_order_relaxed));
  }

  // addRegions() lists the contacts of two regions, and addTiles() those of two tiles. Both return
  // false if it is time to stop.
  bool addRegions(const NearParts& regions) {
    if (isTime()) return false;
    nearTiles(*bodies_.a, regions.a, *bodies_.b, regions.b, needed_m_, tiles_);
    for (const NearParts& tiles : tiles_) {
      if (!bodies_.mayCount(bodies_.a->partOfTile(tiles.a), bodies_.b->partOfTile(tiles.b))) {
        continue;
      }
      if (!addTiles(tiles)) return false;
    }
    return true;
  }

  bool addTiles(const NearParts& tiles) {
    constexpr std::size_t kLook = 64;  // pairs of triangles, about 10 us
    const PosedTile &a = bodies_.a->tile(tiles.a), &b = bodies_.b->tile(tiles.b);
    if (lowerGap(a, b) >= needed_m_) return true;
    nearTriangles(a, b, needed_m_, triangles_);
    if (isTime()) return false;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      addTriangles(a, b, triangles_[i]);
      if ((i + 1) % kLook == 0 && isTime()) return false;
    }
    return true;
  }

  // Lists two triangles if they are in contact. It asks the same predicates as the exact detectors.
  void addTriangles(const PosedTile& a, const PosedTile& b, const NearTriangles& near) {
    if (!bodies_.counts(a.triangle[near.a], b.triangle[near.b])) return;
    const Triangle triangle_a = a.posed(near.a), triangle_b = b.posed(near.b);
    PairFacts facts;
    facts.margin_m = bodies_.margin_m;
    if (!isCandidate(triangle_a, triangle_b, facts)) return;
    PredicateState state{Predicates::kExact};
    const Verdict verdict = candidateVerdict(triangle_a, triangle_b, facts, state);
    if (!verdict.contact) return;
    contacts_.push_back({{bodies_.a_id, a.triangle[near.a], bodies_.b_id, b.triangle[near.b]},
                         verdict.separation_m});
    all_found_.fetch_add(1, std::memory_order_relaxed);
  }

  BodyPair bodies_;
  double needed_m_;  // what is farther apart is no contact
  const CycleLimit& limit_;
  SteadyTime until_;
  std::atomic<std::size_t>& all_found_;
  std::vector<ListedContact> contacts_;
  std::vector<NearParts> regions_, tiles_;  // scratch
  std::vector<NearTriangles> triangles_;
};

}  // namespace

std::vector<SearchedPair> searchesOf(const Scene& scene,
                                     const std::vector<std::pair<BodyId, BodyId>>& pairs,
                                     bool by_part) {
  std::vector<SearchedPair> searches;
  for (const auto& [a, b] : pairs) {
    searches.push_back({a, b, std::nullopt});
    const Body &body_a = scene.body(a), &body_b = scene.body(b);
    if (!by_part || (body_a.parts.empty() && body_b.parts.empty())) continue;
    for (const PartId part_a : body_a.listed_parts) {
      for (const PartId part_b : body_b.listed_parts) {
        if (!scene.partPairEnabled(a, part_a, b, part_b)) continue;
        searches.push_back({a, b, PartPair{a, b, part_a, part_b}});
      }
    }
  }
  return searches;
}

void PairRounds::begin(const Scene& scene, const std::vector<SearchedPair>& pairs,
                       const std::vector<std::shared_ptr<const Tiling>>& tilings,
                       const SearchGoal& goal, const CycleLimit& limit) {
  goal_ = goal;
  tiles_.resize(scene.bodyCount());
  ready_.assign(scene.bodyCount(), false);
  remember();
  parts_.reset();
  const bool by_part = std::any_of(pairs.begin(), pairs.end(),
                                   [](const SearchedPair& pair) { return pair.parts.has_value(); });
  if (by_part || scene.partsMatter()) parts_.emplace(scene);
  std::vector<bool> is_new(scene.bodyCount(), true);
  // Updates the tiles of a body at its first pair. Later pairs get the same answer.
  const auto isReady = [&](BodyId id) {
    if (is_new[id]) {
      if (tiles_[id] == nullptr) tiles_[id] = std::make_unique<BodyTiles>();
      ready_[id] = !limit.over() && tiles_[id]->update(scene.body(id), tilings[id], limit);
    }
    is_new[id] = false;
    return ready_[id];
  };
  for (const auto& [a, b, parts] : pairs) {
    const Body &body_a = scene.body(a), &body_b = scene.body(b);
    Pair pair{a,
              b,
              parts,
              pairMargin(body_a.margin_m, body_b.margin_m),
              body_a.topology_revision,
              body_b.topology_revision,
              nullptr,
              {}};
    if (isReady(a) && isReady(b)) startSearch(pair, goal);
    pairs_.push_back(std::move(pair));
  }
}

// Keeps the nearest triangles of the last cycle's pairs, and forgets these pairs.
void PairRounds::remember() {
  if (pairs_.empty()) return;
  last_.clear();
  for (const Pair& pair : pairs_) {
    const auto nearest = pair.search ? pair.search->nearestSoFar() : std::nullopt;
    if (!nearest) continue;
    last_.push_back({pair.topology_a, pair.topology_b, partsOf(pair), nearest->triangle_a,
                     nearest->triangle_b});
  }
  std::sort(last_.begin(), last_.end(), isBefore);
  pairs_.clear();
}

CountedParts PairRounds::countedIn(const Pair& pair) const {
  CountedParts counted;
  if (!parts_) return counted;
  counted.table = &*parts_;
  if (!pair.parts) return counted;
  counted.only_a = parts_->numberOf(pair.a, pair.parts->part_a);
  counted.only_b = parts_->numberOf(pair.b, pair.parts->part_b);
  return counted;
}

// Results with a tolerance depend on where a search starts, so only one for the nearest pair starts
// from the last cycle. Parts have no list of bounds, so their nearest pairs are always exact.
void PairRounds::startSearch(Pair& pair, const SearchGoal& of_bodies) {
  SearchGoal goal = of_bodies;
  if (pair.parts) goal.tolerance_m = 0;
  pair.search = std::make_unique<PairSearch>(bodiesOf(pair, pair.margin_m), goal);
  if (!goal.nearest) return;
  const Last key{pair.topology_a, pair.topology_b, partsOf(pair), 0, 0};
  const auto found = std::lower_bound(last_.begin(), last_.end(), key, isBefore);
  if (found == last_.end() || isBefore(key, *found)) return;
  pair.search->startFrom(found->triangle_a, found->triangle_b);
}

std::vector<PairRounds::Pair*> PairRounds::openPairs() {
  std::vector<Pair*> open;
  for (Pair& pair : pairs_) {
    if (pair.search != nullptr && !pair.search->isDone()) open.push_back(&pair);
  }
  return open;
}

void PairRounds::decide(const CycleLimit& limit, SteadyTime until) {
  // The length of a turn. Without a deadline, a pair is searched to its end in one turn.
  constexpr std::chrono::microseconds kTurn(100);
  const bool in_turns = limit.isSet() || until != SteadyTime::max();
  for (std::vector<Pair*> open = openPairs(); !open.empty(); open = openPairs()) {
    if (in_turns && (limit.over() || std::chrono::steady_clock::now() >= until)) return;
    parallelBlocks(open.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
      SteadyTime turn = until;
      if (in_turns) turn = std::min(until, std::chrono::steady_clock::now() + kTurn);
      if (!limit.over()) open[i]->search->advance(limit, turn);
    });
  }
}

void PairRounds::list(const CycleLimit& limit, SteadyTime until, bool near_pairs) {
  std::atomic<std::size_t> all_found{0};
  parallelBlocks(limit, pairs_.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
    Pair& pair = pairs_[i];
    if (pair.search == nullptr || pair.parts) return;
    const PairDecision decision = pair.search->decision();
    // A pair that is certainly apart has no contacts. A pair that is still open had no time.
    if (decision == PairDecision::kNone || decision == PairDecision::kOpen) return;
    if (goal_.nearest && !pair.search->isExact()) return;
    pair.is_listed = !near_pairs && decision == PairDecision::kNear;  // it has no contacts
    if (pair.is_listed) return;
    const float margin_m = near_pairs ? pair.margin_m : 0;
    ContactList found(bodiesOf(pair, margin_m), limit, until, all_found);
    pair.is_listed = found.find();
    pair.listed = found.takeContacts();
  });
}

std::vector<BodyDistance> PairRounds::distances() const {
  std::vector<BodyDistance> distances;
  for (const Pair& pair : pairs_) {
    if (pair.parts) continue;
    BodyDistance distance;
    distance.body_a = pair.a;
    distance.body_b = pair.b;
    if (pair.search != nullptr) {
      distance = pair.search->distance();
      distance.is_listed = pair.is_listed || pair.search->decision() == PairDecision::kNone;
    }
    distances.push_back(distance);
  }
  return distances;
}

void PairRounds::addNearest(const Scene& scene, DetectionResult& result) const {
  for (const Pair& pair : pairs_) {
    const auto best = pair.search ? pair.search->nearest() : std::nullopt;
    if (!best) continue;
    const TrianglePair triangles{pair.a, best->triangle_a, pair.b, best->triangle_b};
    const NearestPair nearest = nearestPairOf(scene, triangles, best->distance_m);
    if (pair.parts) {
      result.nearest_parts.push_back({*pair.parts, nearest});
    } else {
      result.nearest.push_back(nearest);
    }
  }
  std::sort(result.nearest.begin(), result.nearest.end());
  std::sort(result.nearest_parts.begin(), result.nearest_parts.end());
}

bool PairRounds::allPartsSearched() const {
  return std::all_of(pairs_.begin(), pairs_.end(), [](const Pair& pair) {
    return !pair.parts || (pair.search != nullptr && pair.search->isExact());
  });
}

std::vector<ListedContact> PairRounds::contacts() const {
  std::vector<ListedContact> contacts;
  for (const Pair& pair : pairs_) {
    contacts.insert(contacts.end(), pair.listed.begin(), pair.listed.end());
    // The search itself has found some contacts. They count where the list is incomplete.
    if (pair.search == nullptr || pair.is_listed || pair.parts) continue;
    for (const TrianglePair& seen : pair.search->contacts()) contacts.push_back({seen, 0});
  }
  std::sort(contacts.begin(), contacts.end(),
            [](const ListedContact& x, const ListedContact& y) { return x.pair < y.pair; });
  contacts.erase(
      std::unique(contacts.begin(), contacts.end(),
                  [](const ListedContact& x, const ListedContact& y) { return x.pair == y.pair; }),
      contacts.end());
  return contacts;
}

}  // namespace deformable_contact_monitor
