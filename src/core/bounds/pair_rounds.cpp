#include "core/bounds/pair_rounds.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include "core/common/parallel.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {

void PairRounds::begin(const Scene& scene, const std::vector<std::pair<BodyId, BodyId>>& pairs,
                       const std::vector<std::shared_ptr<const Tiling>>& tilings, float tolerance_m,
                       const CycleLimit& limit) {
  tolerance_m_ = tolerance_m;
  tiles_.resize(scene.bodyCount());
  ready_.assign(scene.bodyCount(), false);
  pairs_.clear();
  std::vector<bool> is_new(scene.bodyCount(), true);
  const auto isReady = [&](BodyId id) {
    if (is_new[id]) {
      if (tiles_[id] == nullptr) tiles_[id] = std::make_unique<BodyTiles>();
      ready_[id] = !limit.over() && tiles_[id]->update(scene.body(id), tilings[id], limit);
    }
    is_new[id] = false;
    return ready_[id];
  };
  for (const auto& [a, b] : pairs) {
    Pair pair{a, b, pairMargin(scene.body(a).margin_m, scene.body(b).margin_m), nullptr, {}};
    if (isReady(a) && isReady(b)) {
      pair.search = std::make_unique<PairSearch>(bodiesOf(pair), tolerance_m);
    }
    pairs_.push_back(std::move(pair));
  }
}

std::vector<PairRounds::Pair*> PairRounds::openPairs() {
  std::vector<Pair*> open;
  for (Pair& pair : pairs_) {
    if (pair.search != nullptr && !pair.search->isDone()) open.push_back(&pair);
  }
  return open;
}

void PairRounds::decide(const CycleLimit& limit, SteadyTime until) {
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

void PairRounds::list(const CycleLimit& limit, SteadyTime until) {
  std::atomic<std::size_t> all_found{0};
  parallelBlocks(limit, pairs_.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
    Pair& pair = pairs_[i];
    if (pair.search == nullptr) return;
    const PairDecision decision = pair.search->decision();
    if (decision == PairDecision::kNone || decision == PairDecision::kOpen) return;
    PairList found(until, all_found);
    pair.is_listed = found.find(bodiesOf(pair), limit);
    pair.listed = found.contacts();
  });
}

std::vector<BodyDistance> PairRounds::distances() const {
  std::vector<BodyDistance> distances;
  for (const Pair& pair : pairs_) {
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

std::vector<ListedContact> PairRounds::contacts() const {
  std::vector<ListedContact> contacts;
  for (const Pair& pair : pairs_) {
    contacts.insert(contacts.end(), pair.listed.begin(), pair.listed.end());
    if (pair.search == nullptr || pair.is_listed) continue;
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
