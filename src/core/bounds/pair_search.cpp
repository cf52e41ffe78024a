// Searches the distance of two bodies by branch and bound. A heap holds pairs of regions and pairs
// of tiles, each with a lower bound of its distance. The pair with the least bound is refined next:
// regions into tiles, tiles into triangles. The nearest two triangles so far are the witness and
// give the upper bound. The search ends when both bounds decide the pair.
#include "core/bounds/pair_search.h"

#include <algorithm>
#include <cfloat>
#include <chrono>
#include <cmath>

#include "core/bounds/distance_rounding.h"
#include "core/predicates/triangle_distance.h"
#include "core/predicates/triangle_intersection.h"
#include "core/rules/geometry_of_pair.h"

namespace deformable_contact_monitor {
namespace {

// Returns whether the search has to pause.
bool isTime(const CycleLimit& limit, SteadyTime until) {
  if (limit.over()) return true;
  return until != SteadyTime::max() && std::chrono::steady_clock::now() >= until;
}

}  // namespace

PairSearch::PairSearch(const BodyPair& bodies, float tolerance_m)
    : bodies_(bodies), tolerance_m_(tolerance_m), needed_m_(beyond(bodies.margin_m)) {}

// Orders the heap: the least bound comes first. With equal bounds, such as 0, tiles come before
// regions, which keeps the heap small.
bool PairSearch::isLater(const Doubt& x, const Doubt& y) {
  if (x.low_m != y.low_m) return x.low_m > y.low_m;
  if (x.are_tiles != y.are_tiles) return y.are_tiles;
  return x.a != y.a ? x.a > y.a : x.b > y.b;
}

void PairSearch::push(const NearParts& parts, bool are_tiles) {
  doubts_.push_back({parts.low_m, parts.a, parts.b, are_tiles});
  std::push_heap(doubts_.begin(), doubts_.end(), isLater);
}

PairSearch::Doubt PairSearch::pop() {
  std::pop_heap(doubts_.begin(), doubts_.end(), isLater);
  const Doubt doubt = doubts_.back();
  doubts_.pop_back();
  return doubt;
}

// The witness may change many times in one call, so its points are computed once, at the end.
void PairSearch::advance(const CycleLimit& limit, SteadyTime until) {
  const float before_m = high_m_;
  search(limit, until);
  if (high_m_ < before_m) findPoints();
}

void PairSearch::search(const CycleLimit& limit, SteadyTime until) {
  constexpr std::size_t kLook = 16;
  // All regions of a are compared first. Until then nothing is known of some of them, so distance()
  // does not give a lower bound.
  const std::size_t region_count = bodies_.a->regions().size();
  while (next_region_ < region_count) {
    parts_.clear();
    settle(nearRegions(*bodies_.a, next_region_++, *bodies_.b, needed_m_, parts_));
    for (const NearParts& parts : parts_) push(parts, false);
    if (next_region_ % kLook == 0 && isTime(limit, until)) return;
  }
  while (!isDone()) {
    if (next_triangles_ < triangles_.size()) {
      lookAtTriangles(limit, until);
    } else {
      const Doubt doubt = pop();
      doubt.are_tiles ? openTiles(doubt) : lookAtRegions(doubt);
    }
    if (isTime(limit, until)) return;
  }
}

bool PairSearch::isDone() const {
  const bool all = next_region_ == bodies_.a->regions().size() && doubts_.empty() &&
                   next_triangles_ == triangles_.size();
  return all || decision() != PairDecision::kOpen;
}

PairDecision PairSearch::decision() const {
  return decide(distance(), bodies_.margin_m, tolerance_m_);
}

BodyDistance PairSearch::distance() const {
  BodyDistance distance;
  distance.body_a = bodies_.a_id;
  distance.body_b = bodies_.b_id;
  if (next_region_ == bodies_.a->regions().size()) distance.low_m = roundedDown(restLow());
  distance.high_m = high_m_;
  distance.witness = witness_;
  distance.point_a = points_[0];
  distance.point_b = points_[1];
  return distance;
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

// Replaces two regions by pairs of their tiles. The bound of a part is never less than that of the
// whole, so the lower bound of the search only grows.
void PairSearch::lookAtRegions(const Doubt& doubt) {
  settle(nearTiles(*bodies_.a, doubt.a, *bodies_.b, doubt.b, needed_m_, parts_));
  for (const NearParts& parts : parts_)
    push({most(parts.low_m, doubt.low_m), parts.a, parts.b}, true);
}

// Computes where the witness's triangles are nearest. If they intersect, both points are the same.
void PairSearch::findPoints() {
  const PairGeometry geometry = geometryOf(bodies_.a->posedTriangle(witness_.triangle_a),
                                           bodies_.b->posedTriangle(witness_.triangle_b), high_m_);
  points_[0] = geometry.point_a;
  points_[1] = high_m_ > 0 ? geometry.point_b : geometry.point_a;
}

// Lists the near triangles of two tiles. The list leaves out what is beyond the margin, and with it
// each witness that the tolerance alone would allow, so findWitness() is tried from time to time.
void PairSearch::openTiles(const Doubt& doubt) {
  constexpr std::uint32_t kInVain = 64;  // about 0.3 ms of work
  open_ = doubt;
  if (++opened_ % kInVain == 0 && tolerance_m_ > needed_m_ && findWitness()) return;
  next_triangles_ = 0;
  settle(nearTriangles(bodies_.a->tile(doubt.a), bodies_.b->tile(doubt.b), needed_m_, triangles_));
}

// Looks for a witness among the open tiles' triangles that are apart, but within the tolerance.
// This decides pairs in which many tiles overlap while none of their triangles touch.
bool PairSearch::findWitness() {
  constexpr std::size_t kMost = 8;
  const PosedTile &a = bodies_.a->tile(open_.a), &b = bodies_.b->tile(open_.b);
  settle(nearTriangles(a, b, tolerance_m_, triangles_));
  next_triangles_ = 0;
  while (next_triangles_ < std::min(kMost, triangles_.size()) && high_m_ > tolerance_m_) {
    look(a, b, triangles_[next_triangles_++]);
  }
  return high_m_ <= tolerance_m_;
}

// Tests the triangles of the open tiles until these are done, the pair is decided or it is time.
void PairSearch::lookAtTriangles(const CycleLimit& limit, SteadyTime until) {
  constexpr std::size_t kLook = 8;  // about 10 us of work
  const PosedTile &a = bodies_.a->tile(open_.a), &b = bodies_.b->tile(open_.b);
  while (next_triangles_ < triangles_.size()) {
    const NearTriangles& pair = triangles_[next_triangles_++];
    const double low_m = most(pair.low_m, open_.low_m);
    if (low_m >= high_m_) {  // so are all later pairs
      settle(low_m);
      next_triangles_ = triangles_.size();
      return;
    }
    look(a, b, pair);
    if (high_m_ <= tolerance_m_) return;
    if (next_triangles_ % kLook == 0 && isTime(limit, until)) return;
  }
}

// Tests two triangles, and updates the bounds, the witness and the contacts. Only triangles whose
// boxes overlap (bound 0) can intersect.
void PairSearch::look(const PosedTile& a, const PosedTile& b, const NearTriangles& pair) {
  const Triangle hull_a = a.posed(pair.a), hull_b = b.posed(pair.b);
  const TrianglePair ids{bodies_.a_id, a.triangle[pair.a], bodies_.b_id, b.triangle[pair.b]};
  // Triangles that are farther apart than this are no better witness, and do not change the
  // decision.
  const double enough_m = least<double>(high_m_, most<double>(needed_m_, tolerance_m_));
  if (arePlanesApart(hull_a, hull_b, enough_m)) {
    settle(enough_m);
    return;
  }
  PredicateState state{Predicates::kExact};
  if (pair.low_m == 0 && trianglesIntersect(hull_a, hull_b, state)) {
    settle(0);
    high_m_ = 0;
    witness_ = ids;
    contacts_.push_back(ids);
    return;
  }
  const DistanceRange range = rangeOf(separation(hull_a, hull_b));
  settle(range.low_m);
  if (range.high_m < high_m_) {
    high_m_ = range.high_m;
    witness_ = ids;
  }
}

}  // namespace deformable_contact_monitor
