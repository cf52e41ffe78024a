// Searches the distance of two bodies by branch and bound. It refines pairs of regions, then of
// tiles, then of triangles, those with the least lower bound first, until the pair is decided
// within a tolerance, or until its nearest triangles are known exactly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/body_distance.h"
#include "core/bounds/body_tiles.h"
#include "core/bounds/near_parts.h"
#include "core/common/cycle_limit.h"
#include "core/common/part_table.h"
#include "core/detector.h"
#include "core/rules/nearest.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Which triangles of two bodies count, by their parts.
struct CountedParts {
  static constexpr std::uint32_t kAll = ~std::uint32_t{0};

  const PartTable* table = nullptr;  // null: all triangles count
  // Only triangles of these parts count, given by their numbers in the table.
  std::uint32_t only_a = kAll, only_b = kAll;
};

// Two bodies of a cycle, with a_id < b_id.
struct BodyPair {
  BodyId a_id, b_id;
  const BodyTiles *a, *b;
  float margin_m;  // of the pair
  CountedParts parts = {};

  // Returns whether a pair of triangles counts.
  bool counts(std::uint32_t triangle_a, std::uint32_t triangle_b) const {
    return parts.table == nullptr ||
           numbersCount(parts.table->of(a_id, triangle_a), parts.table->of(b_id, triangle_b));
  }
  // Returns whether some pair of triangles of two tiles or regions may count. `part_a`, `part_b`:
  // the parts that BodyTiles gives them.
  bool mayCount(std::uint32_t part_a, std::uint32_t part_b) const {
    if (parts.table == nullptr) return true;
    if (part_a == BodyTiles::kSeveralParts || part_b == BodyTiles::kSeveralParts) return true;
    return numbersCount(parts.table->numberOf(a_id, static_cast<PartId>(part_a)),
                        parts.table->numberOf(b_id, static_cast<PartId>(part_b)));
  }

 private:
  bool numbersCount(std::uint32_t a, std::uint32_t b) const {
    return (parts.only_a == CountedParts::kAll || parts.only_a == a) &&
           (parts.only_b == CountedParts::kAll || parts.only_b == b) &&
           parts.table->pairs().enabled(a, b);
  }
};

// When a search is done.
struct SearchGoal {
  // The pair is decided within this error [m]. With `nearest`, 0 means that this is not enough.
  float tolerance_m = 0;
  bool nearest = false;    // go on until the nearest pair is known exactly
  bool are_apart = false;  // it is known that no triangles of the two bodies intersect
};

// One thread at a time. Its results do not depend on where advance() was interrupted.
class PairSearch {
 public:
  // Begins a search. The tiles of both bodies must live, unchanged, until it ends.
  PairSearch(const BodyPair& bodies, const SearchGoal& goal);

  // Tests two triangles first, such as the nearest ones of the last cycle. They need not be near.
  void startFrom(std::uint32_t triangle_a, std::uint32_t triangle_b);

  // Continues the search until it is done, `until` is reached or the limit is over. Checks the time
  // every few tens of microseconds. Each call makes some progress.
  void advance(const CycleLimit& limit, SteadyTime until);

  // Returns whether the goal is reached, or there is nothing left to search.
  bool isDone() const;
  // Return what is known so far. It is right at any time, and only becomes more exact.
  PairDecision decision() const;
  BodyDistance distance() const;

  // Returns whether the nearest pair is known.
  bool isExact() const { return goal_.nearest && isExhausted(); }
  // Returns the nearest pair if it is known and within the margin.
  std::optional<ComparedPair> nearest() const;
  // Returns the nearest pair found so far that is within the margin.
  std::optional<ComparedPair> nearestSoFar() const;

  // Returns the pairs of triangles that were found to intersect, in any order; the same one may be
  // there twice. If the witness intersects, it is one of them.
  const std::vector<TrianglePair>& contacts() const { return contacts_; }

 private:
  enum class Parts : std::uint8_t { kOrientedTiles, kTiles, kRegions };

  // A pair of regions or of tiles of which only a lower bound is known. kOrientedTiles: the bound
  // is that of the oriented boxes too.
  struct Doubt {
    double low_m;
    std::uint32_t a, b;
    std::uint32_t first_a, first_b;  // the least indices of their triangles
    Parts parts;
  };
  static bool isLater(const Doubt& x, const Doubt& y);

  bool mayPrecede(double low_m, std::uint32_t first_a, std::uint32_t first_b) const;
  void push(const Doubt& doubt);
  Doubt pop();
  // Records the lower bound of pairs that need no further test.
  void settle(double low_m) { settled_m_ = least(settled_m_, low_m); }
  bool isExhausted() const;
  double restLow() const;

  void search(const CycleLimit& limit, SteadyTime until);
  void findStart();
  void refine();
  void compareRegions(std::size_t region_a);
  void openRegions(const Doubt& doubt);
  void compareTiles(Doubt doubt);
  void openTiles(const Doubt& doubt);
  bool findWitness();
  void testTriangles(const CycleLimit& limit, SteadyTime until);
  void test(const Triangle& hull_a, const Triangle& hull_b, const ComparedPair& ids,
            bool boxes_meet);
  void take(const ComparedPair& pair, float high_m);
  bool hasDirection();
  void findPoints();

  BodyPair bodies_;
  SearchGoal goal_;
  bool has_begun_ = false;
  std::size_t next_region_ = 0;  // of body a; earlier ones are in the heap or done
  std::vector<Doubt> doubts_;    // a heap
  double settled_m_ =
      std::numeric_limits<double>::infinity();  // lower bound of all pairs that are done

  // The nearest pair so far. While none is found, its distance is the largest that counts, and its
  // triangles come after all others.
  ComparedPair best_;
  double needed_m_;  // pairs at least so far apart cannot precede it [m]
  float high_m_ = std::numeric_limits<float>::infinity();
  ComparedPair witness_;    // the best pair, or one within the tolerance but beyond the margin
  Vec3f points_[2];         // the witness's nearest points
  Vec3d direction_;         // from the first to the second; zero if there is none
  bool has_points_ = true;  // these are of the present witness, if there is one
  std::vector<TrianglePair> contacts_;

  // The pair of tiles that is open now, and its pairs of triangles from next_triangles_ on.
  Doubt open_{0, 0, 0, 0, 0, Parts::kOrientedTiles};
  std::vector<NearTriangles> triangles_;
  std::size_t next_triangles_ = 0;
  std::uint32_t opened_ = 0;      // how many pairs of tiles were opened
  std::vector<NearParts> parts_;  // scratch
};

}  // namespace deformable_contact_monitor
