// Searches the distance of two bodies by branch and bound. It refines pairs of regions, then of
// tiles, then of triangles, those with the least lower bound first, until the pair is decided.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/body_distance.h"
#include "core/bounds/body_tiles.h"
#include "core/bounds/near_parts.h"
#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Two bodies of a cycle, with a_id < b_id.
struct BodyPair {
  BodyId a_id, b_id;
  const BodyTiles *a, *b;
  float margin_m;  // of the pair
};

// One thread at a time. Its results do not depend on where advance() was interrupted.
class PairSearch {
 public:
  // Begins a search. The tiles of both bodies must live, unchanged, until it ends.
  PairSearch(const BodyPair& bodies, float tolerance_m);

  // Continues the search until the pair is decided, `until` is reached or the limit is over. Checks
  // the time every few tens of microseconds. Each call makes some progress.
  void advance(const CycleLimit& limit, SteadyTime until);

  // Returns whether the pair is decided, or there is nothing left to search.
  bool isDone() const;
  // Return what is known so far. It is right at any time, and only becomes more exact.
  PairDecision decision() const;

  BodyDistance distance() const;

  // Returns the pairs of triangles that were found to intersect, in any order, each once. If the
  // witness intersects, it is one of them.
  const std::vector<TrianglePair>& contacts() const { return contacts_; }

 private:
  // A pair of regions or of tiles of which only a lower bound is known.
  struct Doubt {
    double low_m;
    std::uint32_t a, b;
    bool are_tiles;
  };
  static bool isLater(const Doubt& x, const Doubt& y);

  void push(const NearParts& parts, bool are_tiles);
  Doubt pop();
  // Records the lower bound of pairs that need no further test.
  void settle(double low_m) { settled_m_ = least(settled_m_, low_m); }
  void search(const CycleLimit& limit, SteadyTime until);
  double restLow() const;
  void lookAtRegions(const Doubt& doubt);
  void openTiles(const Doubt& doubt);
  bool findWitness();
  void lookAtTriangles(const CycleLimit& limit, SteadyTime until);
  void findPoints();
  void look(const PosedTile& a, const PosedTile& b, const NearTriangles& pair);

  BodyPair bodies_;
  float tolerance_m_;
  double needed_m_;              // pairs at least so far apart are beyond the margin [m]
  std::size_t next_region_ = 0;  // of body a; earlier ones are in the heap or done
  std::vector<Doubt> doubts_;    // a heap
  double settled_m_ =
      std::numeric_limits<double>::infinity();  // lower bound of all pairs that are done
  float high_m_ = std::numeric_limits<float>::infinity();
  TrianglePair witness_{0, 0, 0, 0};
  Vec3f points_[2];  // the witness's
  std::vector<TrianglePair> contacts_;
  // The pair of tiles that is open now, and its pairs of triangles from next_triangles_ on.
  Doubt open_{0, 0, 0, true};
  std::vector<NearTriangles> triangles_;
  std::size_t next_triangles_ = 0;
  std::uint32_t opened_ = 0;      // how many pairs of tiles were opened
  std::vector<NearParts> parts_;  // scratch
};

}  // namespace deformable_contact_monitor
