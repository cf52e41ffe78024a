// Searches the distance of two bodies by branch and bound. A heap holds pairs of regions and pairs
// of tiles, each with a lower bound of its distance. The pair with the least bound is refined next:
// regions into tiles, tiles by their oriented boxes, and these into triangles. The nearest two
// triangles so far give the upper bound. Parts that cannot hold a pair that precedes it
// (rules/nearest.h) are left out. The search ends when both bounds decide the pair, or when nothing
// is left.
#include "core/bounds/pair_search.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/bounds/distance_rounding.h"
#include "core/predicates/triangle_distance.h"
#include "core/predicates/triangle_intersection.h"
#include "core/rules/geometry_of_pair.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kNoTriangle = ~std::uint32_t{0};

// Returns whether the search has to pause.
bool isTime(const CycleLimit& limit, SteadyTime until) {
  if (limit.over()) return true;
  return until != SteadyTime::max() && std::chrono::steady_clock::now() >= until;
}

bool comesBefore(std::uint32_t a, std::uint32_t b, const ComparedPair& pair) {
  return a != pair.triangle_a ? a < pair.triangle_a : b < pair.triangle_b;
}

// Returns which of the boxes with the numbers from `begin` up to `end` is nearest to a box; `end`
// if all are empty. `boxAt` returns the box of a number.
template <class BoxAt>
std::size_t nearestBox(const Aabb& to, std::size_t begin, std::size_t end, const BoxAt& boxAt) {
  double least2 = INFINITY;
  std::size_t nearest = end;
  for (std::size_t i = begin; i < end; ++i) {
    const Aabb box = boxAt(i);
    if (box.empty()) continue;
    const double gap2 = squaredGap(to, box);
    if (gap2 >= least2) continue;
    least2 = gap2;
    nearest = i;
  }
  return nearest;
}

// Returns a region of `body` near to a box, and a tile of it near to a box.
std::size_t nearestRegion(const BodyTiles& body, const Aabb& to) {
  return nearestBox(to, 0, body.regions().size(),
                    [&body](std::size_t r) { return body.regions()[r]; });
}

std::size_t nearestTile(const BodyTiles& body, std::size_t region, const Aabb& to) {
  return nearestBox(to, body.tileBegin(region), body.tileEnd(region),
                    [&body](std::size_t tile) { return body.tileBox(tile); });
}

}  // namespace

// Without `nearest`, a distance that is only just beyond the margin counts too, so that rounding
// leaves no pair open.
PairSearch::PairSearch(const BodyPair& bodies, const SearchGoal& goal)
    : bodies_(bodies),
      goal_(goal),
      best_{goal.nearest ? bodies.margin_m : static_cast<float>(beyond(bodies.margin_m)),
            kNoTriangle, kNoTriangle},
      needed_m_(certainlyBeyond(best_.distance_m)),
      witness_(best_) {}

// Orders the heap: the least bound comes first. With equal bounds, such as 0, tiles come before
// regions, which keeps the heap small, and then the least triangles, because these win a tie.
bool PairSearch::isLater(const Doubt& x, const Doubt& y) {
  if (x.low_m != y.low_m) return x.low_m > y.low_m;
  if (x.parts != y.parts) return x.parts > y.parts;
  return x.first_a != y.first_a ? x.first_a > y.first_a : x.first_b > y.first_b;
}

// Returns whether pairs of triangles from these on, at least low_m apart, may precede the best one.
bool PairSearch::mayPrecede(double low_m, std::uint32_t first_a, std::uint32_t first_b) const {
  if (low_m >= needed_m_) return false;
  return ComparedPair{leastCompared(low_m), first_a, first_b}.precedes(best_);
}

void PairSearch::push(const Doubt& doubt) {
  if (!mayPrecede(doubt.low_m, doubt.first_a, doubt.first_b)) return settle(doubt.low_m);
  doubts_.push_back(doubt);
  std::push_heap(doubts_.begin(), doubts_.end(), isLater);
}

PairSearch::Doubt PairSearch::pop() {
  std::pop_heap(doubts_.begin(), doubts_.end(), isLater);
  const Doubt doubt = doubts_.back();
  doubts_.pop_back();
  return doubt;
}

void PairSearch::startFrom(std::uint32_t triangle_a, std::uint32_t triangle_b) {
  if (!bodies_.counts(triangle_a, triangle_b)) return;
  const Triangle a = bodies_.a->posedTriangle(triangle_a);
  const Triangle b = bodies_.b->posedTriangle(triangle_b);
  if (!isFinite(a) || !isFinite(b)) return;
  test(a, b, {0, triangle_a, triangle_b}, intersects(boxOf(a), boxOf(b)));
  findPoints();
}

// The witness may change many times in one call, so its points are computed once, at the end.
void PairSearch::advance(const CycleLimit& limit, SteadyTime until) {
  search(limit, until);
  findPoints();
}

void PairSearch::search(const CycleLimit& limit, SteadyTime until) {
  constexpr std::size_t kLook = 16;
  if (!has_begun_) findStart();
  has_begun_ = true;
  // All regions of a are compared first. Until then nothing is known of some of them, so distance()
  // does not give a lower bound.
  while (next_region_ < bodies_.a->regions().size()) {
    compareRegions(next_region_++);
    if (next_region_ % kLook == 0 && isTime(limit, until)) return;
  }
  while (!isDone()) {
    if (next_triangles_ < triangles_.size()) {
      testTriangles(limit, until);
    } else {
      refine();
    }
    if (isTime(limit, until)) return;
  }
}

bool PairSearch::isExhausted() const {
  return next_region_ == bodies_.a->regions().size() && doubts_.empty() &&
         next_triangles_ == triangles_.size() && has_begun_;
}

bool PairSearch::isDone() const {
  if (isExhausted()) return true;
  if (goal_.nearest && goal_.tolerance_m == 0) return false;
  return decision() != PairDecision::kOpen;
}

PairDecision PairSearch::decision() const {
  return decide(distance(), bodies_.margin_m, goal_.tolerance_m);
}

BodyDistance PairSearch::distance() const {
  BodyDistance distance;
  distance.body_a = bodies_.a_id;
  distance.body_b = bodies_.b_id;
  if (next_region_ == bodies_.a->regions().size()) {
    // Bodies that are certainly apart have at least the least float32 as their distance.
    constexpr float kLeast = 0x1p-149F;
    const double low_m = restLow();
    distance.low_m = low_m > 0 ? most(kLeast, roundedDown(low_m)) : 0;
  }
  distance.high_m = high_m_;
  if (high_m_ < INFINITY) {
    distance.witness = {bodies_.a_id, witness_.triangle_a, bodies_.b_id, witness_.triangle_b};
  }
  distance.point_a = points_[0];
  distance.point_b = points_[1];
  // A distance beyond the largest float32 has no upper bound.
  distance.is_exact = isExact() && (high_m_ < INFINITY) == nearestSoFar().has_value();
  return distance;
}

std::optional<ComparedPair> PairSearch::nearestSoFar() const {
  if (best_.triangle_a == kNoTriangle || best_.distance_m > bodies_.margin_m) return std::nullopt;
  return best_;
}

std::optional<ComparedPair> PairSearch::nearest() const {
  return isExact() ? nearestSoFar() : std::nullopt;
}

// Returns a lower bound of the distance of all pairs of triangles [m]. It is the least bound of
// what was left out or done, of the heap, and of the open tiles, whose nearest triangles come
// first.
double PairSearch::restLow() const {
  double low_m = settled_m_;
  if (!doubts_.empty()) low_m = least(low_m, doubts_.front().low_m);
  if (next_triangles_ < triangles_.size()) {
    low_m = least(low_m, most(open_.low_m, triangles_[next_triangles_].low_m));
  }
  return low_m;
}

// Finds a first upper bound where none is known: goes down to two tiles that are near each other,
// and tests their nearest triangles. The search tests these again, with all others.
void PairSearch::findStart() {
  constexpr std::size_t kMost = 4;
  if (best_.triangle_a != kNoTriangle) return;
  const BodyTiles &a = *bodies_.a, &b = *bodies_.b;
  if (a.box().empty() || b.box().empty()) return;
  if (std::sqrt(squaredGap(a.box(), b.box())) >= needed_m_) return;
  std::size_t region_b = nearestRegion(b, a.box());
  const std::size_t region_a = nearestRegion(a, b.regions()[region_b]);
  region_b = nearestRegion(b, a.regions()[region_a]);
  std::size_t tile_b = nearestTile(b, region_b, a.regions()[region_a]);
  const std::size_t tile_a = nearestTile(a, region_a, b.tileBox(tile_b));
  tile_b = nearestTile(b, region_b, a.tileBox(tile_a));
  const PosedTile &posed_a = a.tile(tile_a), &posed_b = b.tile(tile_b);
  if (posed_a.count == 0 || posed_b.count == 0) return;
  nearTriangles(posed_a, posed_b, needed_m_, triangles_);
  for (std::size_t i = 0; i < std::min(kMost, triangles_.size()); ++i) {
    const NearTriangles& pair = triangles_[i];
    if (!bodies_.counts(posed_a.triangle[pair.a], posed_b.triangle[pair.b])) continue;
    test(posed_a.posed(pair.a), posed_b.posed(pair.b),
         {0, posed_a.triangle[pair.a], posed_b.triangle[pair.b]}, pair.boxes_meet);
  }
  triangles_.clear();
}

// Refines the pair of parts with the least bound.
void PairSearch::refine() {
  const Doubt doubt = pop();
  if (doubt.low_m >= needed_m_) {  // so are all others
    settle(doubt.low_m);
    doubts_.clear();
  } else if (!mayPrecede(doubt.low_m, doubt.first_a, doubt.first_b)) {
    settle(doubt.low_m);
  } else if (doubt.parts == Parts::kRegions) {
    openRegions(doubt);
  } else if (doubt.parts == Parts::kTiles) {
    compareTiles(doubt);
  } else {
    openTiles(doubt);
  }
}

// Adds the pairs of a region of a with all regions of b.
void PairSearch::compareRegions(std::size_t region_a) {
  parts_.clear();
  settle(nearRegions(*bodies_.a, region_a, *bodies_.b, needed_m_, parts_));
  for (const NearParts& parts : parts_) {
    if (!bodies_.mayCount(bodies_.a->partOfRegion(parts.a), bodies_.b->partOfRegion(parts.b))) {
      continue;
    }
    push({parts.low_m, parts.a, parts.b, bodies_.a->firstOfRegion(parts.a),
          bodies_.b->firstOfRegion(parts.b), Parts::kRegions});
  }
}

// Replaces two regions by pairs of their tiles. The bound of a part is never less than that of the
// whole, so the lower bound of the search only grows.
void PairSearch::openRegions(const Doubt& doubt) {
  settle(nearTiles(*bodies_.a, doubt.a, *bodies_.b, doubt.b, needed_m_, parts_));
  for (const NearParts& parts : parts_) {
    if (!bodies_.mayCount(bodies_.a->partOfTile(parts.a), bodies_.b->partOfTile(parts.b))) continue;
    push({most(parts.low_m, doubt.low_m), parts.a, parts.b, bodies_.a->firstOfTile(parts.a),
          bodies_.b->firstOfTile(parts.b), Parts::kTiles});
  }
}

// Compares the oriented boxes of two tiles. This poses their vertices, so it is done only when
// their turn comes.
void PairSearch::compareTiles(Doubt doubt) {
  doubt.parts = Parts::kOrientedTiles;
  const PosedTile &a = bodies_.a->tile(doubt.a), &b = bodies_.b->tile(doubt.b);
  doubt.low_m = most(doubt.low_m, lowerGap(a, b));
  if (mayPrecede(doubt.low_m, doubt.first_a, doubt.first_b) && hasDirection()) {
    doubt.low_m = most(doubt.low_m, lowerGapAlong(direction_, a, b));
  }
  push(doubt);
}

// Lists the near triangles of two tiles. The list leaves out what is beyond the margin, and with it
// each witness that the tolerance alone would allow, so findWitness() is tried from time to time.
void PairSearch::openTiles(const Doubt& doubt) {
  constexpr std::uint32_t kInVain = 64;  // about 0.3 ms of work
  open_ = doubt;
  if (++opened_ % kInVain == 0 && goal_.tolerance_m > needed_m_ && findWitness()) return;
  next_triangles_ = 0;
  const PosedTile &a = bodies_.a->tile(doubt.a), &b = bodies_.b->tile(doubt.b);
  settle(hasDirection() ? nearTrianglesAlong(direction_, a, b, needed_m_, triangles_)
                        : nearTriangles(a, b, needed_m_, triangles_));
}

// Looks for a witness among the open tiles' triangles that are apart, but within the tolerance.
// This decides pairs in which many tiles overlap while none of their triangles touch.
bool PairSearch::findWitness() {
  constexpr std::size_t kMost = 8;
  const PosedTile &a = bodies_.a->tile(open_.a), &b = bodies_.b->tile(open_.b);
  settle(nearTriangles(a, b, goal_.tolerance_m, triangles_));
  next_triangles_ = 0;
  while (next_triangles_ < std::min(kMost, triangles_.size()) && high_m_ > goal_.tolerance_m) {
    const NearTriangles& pair = triangles_[next_triangles_++];
    if (!bodies_.counts(a.triangle[pair.a], b.triangle[pair.b])) continue;
    test(a.posed(pair.a), b.posed(pair.b), {0, a.triangle[pair.a], b.triangle[pair.b]},
         pair.boxes_meet);
  }
  return high_m_ <= goal_.tolerance_m;
}

// Tests the triangles of the open tiles until these are done, the pair is decided or it is time.
void PairSearch::testTriangles(const CycleLimit& limit, SteadyTime until) {
  constexpr std::size_t kLook = 8;  // about 10 us of work
  const PosedTile &a = bodies_.a->tile(open_.a), &b = bodies_.b->tile(open_.b);
  std::size_t tested = 0;
  while (next_triangles_ < triangles_.size()) {
    const NearTriangles& pair = triangles_[next_triangles_++];
    const double low_m = most(pair.low_m, open_.low_m);
    if (low_m >= needed_m_) {  // so are all later pairs
      settle(low_m);
      next_triangles_ = triangles_.size();
      return;
    }
    const ComparedPair ids{0, a.triangle[pair.a], b.triangle[pair.b]};
    if (!bodies_.counts(ids.triangle_a, ids.triangle_b)) continue;
    if (!mayPrecede(low_m, ids.triangle_a, ids.triangle_b)) {
      settle(low_m);
      continue;
    }
    test(a.posed(pair.a), b.posed(pair.b), ids, pair.boxes_meet);
    if (goal_.tolerance_m > 0 && high_m_ <= goal_.tolerance_m) return;
    if (++tested % kLook == 0 && isTime(limit, until)) return;
  }
}

// Tests two triangles, and updates the bounds, the witness and the contacts. Only triangles whose
// boxes meet can intersect.
void PairSearch::test(const Triangle& hull_a, const Triangle& hull_b, const ComparedPair& ids,
                      bool boxes_meet) {
  // Triangles that are farther apart than this are no better witness, and do not change the
  // decision. Those that come later than the best pair have to be strictly nearer.
  double enough_m = comesBefore(ids.triangle_a, ids.triangle_b, best_)
                        ? needed_m_
                        : certainlyNotBelow(best_.distance_m);
  if (high_m_ > goal_.tolerance_m) enough_m = most<double>(enough_m, goal_.tolerance_m);
  if (arePlanesApart(hull_a, hull_b, enough_m)) return settle(enough_m);
  PredicateState state{Predicates::kExact};
  if (boxes_meet && !goal_.are_apart && trianglesIntersect(hull_a, hull_b, state)) {
    settle(0);
    contacts_.push_back({bodies_.a_id, ids.triangle_a, bodies_.b_id, ids.triangle_b});
    return take({0, ids.triangle_a, ids.triangle_b}, 0);
  }
  const double separation_m = separation(hull_a, hull_b);
  const DistanceRange range = rangeOf(separation_m);
  settle(range.low_m);
  take({comparedDistance(separation_m), ids.triangle_a, ids.triangle_b}, range.high_m);
}

// Takes a pair as the best one if it is, and as the witness if it is the best, or is within the
// tolerance.
void PairSearch::take(const ComparedPair& pair, float high_m) {
  if (pair.precedes(best_)) {
    best_ = pair;
    needed_m_ = certainlyBeyond(pair.distance_m);
  } else if (high_m > goal_.tolerance_m || high_m_ <= goal_.tolerance_m) {
    return;
  }
  witness_ = pair;
  high_m_ = high_m;
  has_points_ = false;
}

// Returns whether the nearest points so far give a direction, in which those of other parts lie
// too, more or less.
bool PairSearch::hasDirection() {
  findPoints();
  return direction_ != Vec3d();
}

// Computes where the witness's triangles are nearest. If they intersect, both points are the same.
void PairSearch::findPoints() {
  if (has_points_) return;
  has_points_ = true;
  const PairGeometry geometry = geometryOf(bodies_.a->posedTriangle(witness_.triangle_a),
                                           bodies_.b->posedTriangle(witness_.triangle_b), high_m_);
  points_[0] = geometry.point_a;
  points_[1] = high_m_ > 0 ? geometry.point_b : geometry.point_a;
  direction_ = toDouble(points_[1]) - toDouble(points_[0]);
}

}  // namespace deformable_contact_monitor
