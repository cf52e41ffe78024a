// Pairs of bodies that are decided by their tiles, turn by turn where time is short.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/bounds/body_tiles.h"
#include "core/bounds/pair_list.h"
#include "core/bounds/pair_search.h"
#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/scene.h"
#include "core/steady_time.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// Keeps what bodies leave for later cycles. One thread at a time calls it, and it uses those of the
// arena that it is called in.
class PairRounds {
 public:
  // Begins a cycle with these pairs, ascending, of two different bodies each. `tilings`: per body
  // of the scene, of those in pairs. The scene must live, unchanged, until the cycle ends.
  void begin(const Scene& scene, const std::vector<std::pair<BodyId, BodyId>>& pairs,
             const std::vector<std::shared_ptr<const Tiling>>& tilings, float tolerance_m,
             const CycleLimit& limit);

  // Goes on with those that are open, until none is or the time has come.
  void decide(const CycleLimit& limit, SteadyTime until);

  // Lists contacts of the pairs that are not certainly apart, until what was found is to be sorted.
  void list(const CycleLimit& limit, SteadyTime until);

  // Of all pairs, in their order.
  std::vector<BodyDistance> distances() const;

  // What was found, sorted, each once.
  std::vector<ListedContact> contacts() const;

  // Whether triangles of a body, one of some pair, may have been rejected. False too where there
  // was no time to look.
  bool mayReject(BodyId id) const { return ready_[id] && !tiles_[id]->allFinite(); }

 private:
  struct Pair {
    BodyId a, b;
    float margin_m;
    std::unique_ptr<PairSearch> search;  // null: there was no time to begin it
    std::vector<ListedContact> listed;
    bool is_listed = false;
  };

  BodyPair bodiesOf(const Pair& pair) const {
    return {pair.a, pair.b, tiles_[pair.a].get(), tiles_[pair.b].get(), pair.margin_m};
  }
  std::vector<Pair*> openPairs();

  float tolerance_m_ = 0;
  std::vector<std::unique_ptr<BodyTiles>> tiles_;  // per body; null: it has been in no pair
  std::vector<bool> ready_;                        // per body: its tiles are of this cycle
  std::vector<Pair> pairs_;
};

}  // namespace deformable_contact_monitor
