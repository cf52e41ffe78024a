#include "core/coarse/pair_search.h"

#include <algorithm>
#include <chrono>
#include <cfloat>
#include <cmath>

#include "core/coarse/distance_rounding.h"
#include "core/predicates/triangle_distance.h"
#include "core/predicates/triangle_intersection.h"

namespace deformable_contact_monitor {
namespace {

bool isTime(const CycleLimit& limit, SteadyTime until) {
  if (limit.over()) return true;
  return until != SteadyTime::max() && std::chrono::steady_clock::now() >= until;
}

}  // namespace

PairSearch::PairSearch(const BodyPair& bodies, float tolerance_m)
    : bodies_(bodies), tolerance_m_(tolerance_m), needed_m_(beyond(bodies.margin_m)) {}

// Where bounds say nothing, tiles come before regions, so that few wait.
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

void PairSearch::advance(const CycleLimit& limit, SteadyTime until) {
  const std::size_t region_count = bodies_.a->regions().size();
  for (; next_region_ < region_count; ++next_region_) {
    parts_.clear();
    settle(nearRegions(*bodies_.a, next_region_, *bodies_.b, needed_m_, parts_));
    for (const NearParts& parts : parts_) push(parts, false);
    if (isTime(limit, until)) {
      ++next_region_;
      return;
    }
  }
  while (!doubts_.empty() && decision() == PairDecision::kOpen) {
    const Doubt doubt = pop();
    if (doubt.are_tiles) {
      lookAtTiles(doubt, limit, until);
    } else {
      lookAtRegions(doubt);
    }
    if (isTime(limit, until)) return;
  }
}

PairDecision PairSearch::decision() const {
  return decide(distance(), bodies_.margin_m, tolerance_m_);
}

BodyDistance PairSearch::distance() const {
  BodyDistance distance;
  distance.body_a = bodies_.a_id;
  distance.body_b = bodies_.b_id;
  if (next_region_ == bodies_.a->regions().size()) {
    const double low_m =
        doubts_.empty() ? settled_m_ : least(settled_m_, doubts_.front().low_m);
    distance.low_m = roundedDown(low_m);
  }
  distance.high_m = high_m_;
  distance.witness = witness_;
  return distance;
}

void PairSearch::lookAtRegions(const Doubt& doubt) {
  settle(nearTiles(*bodies_.a, doubt.a, *bodies_.b, doubt.b, needed_m_, parts_));
  for (const NearParts& parts : parts_) push({most(parts.low_m, doubt.low_m), parts.a, parts.b}, true);
}

void PairSearch::lookAtTiles(const Doubt& doubt, const CycleLimit& limit, SteadyTime until) {
  constexpr std::size_t kLook = 8;  // some 10 us
  const PosedTile &a = bodies_.a->tile(doubt.a), &b = bodies_.b->tile(doubt.b);
  double left_out_m = nearTriangles(a, b, needed_m_, triangles_);
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const double low_m = most(triangles_[i].low_m, doubt.low_m);
    if (low_m >= high_m_) {  // and so are all others
      settle(low_m);
      break;
    }
    lookAtTriangles(a, b, triangles_[i]);
    if (high_m_ <= tolerance_m_ || ((i + 1) % kLook == 0 && isTime(limit, until))) {
      // All others wait.
      push({doubt.low_m, doubt.a, doubt.b}, true);
      return;
    }
  }
  settle(left_out_m);
}

void PairSearch::lookAtTriangles(const PosedTile& a, const PosedTile& b,
                                 const NearTriangles& pair) {
  const Triangle hull_a = a.posed(pair.a), hull_b = b.posed(pair.b);
  const TrianglePair ids{bodies_.a_id, a.triangle[pair.a], bodies_.b_id, b.triangle[pair.b]};
  // What is farther apart is no witness, and does not matter to what is certain.
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
