// What is certain of the distance of two bodies, tile by tile, the most doubtful first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/body_distance.h"
#include "core/bounds/body_tiles.h"
#include "core/bounds/region_pair.h"
#include "core/bounds/tile_pair.h"
#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Two bodies of a cycle; a < b by id.
struct BodyPair {
  BodyId a_id, b_id;
  const BodyTiles *a, *b;
  float margin_m;  // of the pair
};

// One thread at a time. What it finds does not depend on where advance() was interrupted.
class PairSearch {
 public:
  PairSearch(const BodyPair& bodies, float tolerance_m);

  // Goes on until the pair is decided, the time has come or the limit is over; looks at them every
  // few tens of microseconds. Does at least a little.
  void advance(const CycleLimit& limit, SteadyTime until);

  // Nothing more can be found.
  bool isDone() const;
  PairDecision decision() const;

  BodyDistance distance() const;

  // Triangles that were seen to intersect, in any order, each once; at least the witness if it
  // does.
  const std::vector<TrianglePair>& contacts() const { return contacts_; }

 private:
  // A pair of regions or of tiles that nothing is certain of yet but low_m.
  struct Doubt {
    double low_m;
    std::uint32_t a, b;
    bool are_tiles;
  };
  static bool isLater(const Doubt& x, const Doubt& y);

  void push(const NearParts& parts, bool are_tiles);
  Doubt pop();
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
  double needed_m_;              // what is farther apart is so by more than the margin
  std::size_t next_region_ = 0;  // of a: those before have been taken up
  std::vector<Doubt> doubts_;    // a heap
  double settled_m_ = std::numeric_limits<double>::infinity();  // certain of all that is no doubt
  float high_m_ = std::numeric_limits<float>::infinity();
  TrianglePair witness_{0, 0, 0, 0};
  Vec3f points_[2];  // the witness's
  std::vector<TrianglePair> contacts_;
  // The tiles that are being looked at, and of their triangles those that are still to be.
  Doubt open_{0, 0, 0, true};
  std::vector<NearTriangles> triangles_;
  std::size_t next_triangles_ = 0;
  std::uint32_t opened_ = 0;      // pairs of tiles
  std::vector<NearParts> parts_;  // scratch
};

}  // namespace deformable_contact_monitor
