// Searches the distances of the pairs of bodies of one cycle by their tiles, and lists their
// contacts. If there is a deadline, pairs take turns, so that each gets some of the time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/bounds/body_tiles.h"
#include "core/bounds/pair_search.h"
#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/scene.h"
#include "core/steady_time.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// A pair of triangles in contact.
struct ListedContact {
  TrianglePair pair;
  float separation_m;  // as DetectionResult::separations_m
};

// Two different bodies whose distance is searched, or two of their parts.
struct SearchedPair {
  BodyId a, b;
  std::optional<PartPair> parts;  // empty: all of their parts
};

// Returns the searches of pairs of bodies. If it is `by_part`, those of their enabled pairs of
// parts follow each pair that has named parts.
std::vector<SearchedPair> searchesOf(const Scene& scene,
                                     const std::vector<std::pair<BodyId, BodyId>>& pairs,
                                     bool by_part);

// Keeps the tiles of bodies, and the nearest triangles of each pair, for later cycles. One thread
// at a time calls it, and it uses the threads of the TBB arena in which it is called.
class PairRounds {
 public:
  // The nearest triangles of two bodies or parts in the last cycle, by the revisions of their
  // topologies.
  struct Last {
    std::uint64_t topology_a, topology_b;
    int parts;  // part_a * 256 + part_b; -1: all parts
    std::uint32_t triangle_a, triangle_b;
  };

  // Begins a cycle with these pairs, ascending by their bodies. `tilings`: one per
  // body of the scene; null where there is none. With goal.nearest, a search starts from the
  // nearest triangles of the last cycle. The scene must live, unchanged, until the cycle ends.
  void begin(const Scene& scene, const std::vector<SearchedPair>& pairs,
             const std::vector<std::shared_ptr<const Tiling>>& tilings, const SearchGoal& goal,
             const CycleLimit& limit);

  // Continues the search of pairs that are open, until none is, or `until` or the limit is reached.
  void decide(const CycleLimit& limit, SteadyTime until);

  // Lists the contacts of all pairs that are decided and not certainly apart: near pairs too, or
  // only those that touch. Stops early enough that the contacts found so far can be sorted before
  // `until`.
  void list(const CycleLimit& limit, SteadyTime until, bool near_pairs);

  // Returns what is certain of each pair of bodies, in their order.
  std::vector<BodyDistance> distances() const;

  // Adds the nearest pair of each pair of bodies or parts whose search is exact and that is within
  // its margin, and sorts the result's lists of them.
  void addNearest(const Scene& scene, DetectionResult& result) const;

  // Returns whether the search of each pair of parts came to its end.
  bool allPartsSearched() const;

  // Forgets the nearest triangles of earlier cycles.
  void forget() { last_.clear(); }

  // Ends a cycle, and swaps its nearest triangles with `last`. Sets of pairs that take turns keep
  // theirs outside, and swap before begin() too.
  void swapLast(std::vector<Last>& last) {
    remember();
    last_.swap(last);
  }

  // Returns the contacts that were found, sorted, each once.
  std::vector<ListedContact> contacts() const;

  // Returns whether triangles of a body, one of some pair, may have been rejected. Returns false
  // also where there was no time to look at the body.
  bool mayReject(BodyId id) const { return ready_[id] && !tiles_[id]->allFinite(); }

 private:
  // A pair of bodies or parts, and how far its search and its list of contacts have come.
  struct Pair {
    BodyId a, b;
    std::optional<PartPair> parts;
    float margin_m;
    std::uint64_t topology_a, topology_b;  // revisions
    std::unique_ptr<PairSearch> search;    // null: there was no time to begin it
    std::vector<ListedContact> listed;
    bool is_listed = false;  // `listed` is complete
  };

  static bool isBefore(const Last& x, const Last& y) {
    if (x.topology_a != y.topology_a) return x.topology_a < y.topology_a;
    return x.topology_b != y.topology_b ? x.topology_b < y.topology_b : x.parts < y.parts;
  }
  static int partsOf(const Pair& pair) {
    return pair.parts ? pair.parts->part_a * 256 + pair.parts->part_b : -1;
  }
  void remember();
  void startSearch(Pair& pair, const SearchGoal& goal);
  BodyPair bodiesOf(const Pair& pair, float margin_m) const {
    return {pair.a, pair.b, tiles_[pair.a].get(), tiles_[pair.b].get(), margin_m, countedIn(pair)};
  }
  CountedParts countedIn(const Pair& pair) const;
  // Returns the pairs that have a search which is not done.
  std::vector<Pair*> openPairs();

  SearchGoal goal_;
  std::optional<PartTable> parts_;                 // empty: parts do not matter
  std::vector<std::unique_ptr<BodyTiles>> tiles_;  // per body; null: it was never in a pair
  std::vector<bool> ready_;                        // per body: its tiles are those of this cycle
  std::vector<Pair> pairs_;
  std::vector<Last> last_;  // sorted by the revisions
};

}  // namespace deformable_contact_monitor
