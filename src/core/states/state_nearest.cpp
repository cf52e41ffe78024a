// The part of StateSearch that finds nearest pairs.
#include <algorithm>
#include <cmath>

#include "core/common/contact_geometry.h"
#include "core/common/posed_body.h"
#include "core/predicates/triangle_intersection.h"
#include "core/rules/margins.h"
#include "core/states/lane_boxes.h"
#include "core/states/state_search.h"

namespace deformable_contact_monitor {
namespace {

// Returns the bits of the lanes of a node that are not certainly at least needed_m away from a box
// of the other body, and computes how far they are at least.
std::uint32_t lanesNearer(const LaneAxes& axes, const CentredBox& single, const BoxNode& node,
                          double needed_m, double (&gaps_m)[BoxNode::kLanes]) {
  float squared[BoxNode::kLanes];
  squaredGapsOfLanes(axes, single, node, squared);
  std::uint32_t lanes = 0;
  for (std::uint32_t lane = 0; lane < BoxNode::kLanes; ++lane) {
    gaps_m[lane] = std::sqrt(double{squared[lane]}) * (1 - 1e-6);
    lanes |= std::uint32_t{gaps_m[lane] < needed_m} << lane;
  }
  return lanes & node.used;
}

}  // namespace

// Searches all pairs of bodies at once, best first, because only the nearest of all is asked for.
void StateSearch::findNearest() {
  heap_.clear();
  // If bodies touch, only the first two that do matter, and only their triangles that touch. To
  // know that takes little time.
  has_points_ = true;
  direction_ = Vec3d();
  for (std::uint32_t i = 0; i < task_->pairs.size() && best_.pair == Best::kNone; ++i) {
    if (touches(i)) best_ = {0, i, {INFINITY, Best::kNone, Best::kNone}};
  }
  for (std::uint32_t i = 0; i < task_->pairs.size(); ++i) {
    const StatePair& pair = task_->pairs[i];
    if (!mayBeWithin(pair, pair.radii.triangleDistanceM(pair.margin_m))) continue;
    const BoxNode &a = pair.a->nodes()[0], &b = pair.b->nodes()[0];
    const double low_m = std::sqrt(frameOf(i).squaredGap(a.box, b.box, INFINITY)) * (1 - 1e-6);
    push({low_m - pair.radii.sum(), low_m, i, 0, 0, *std::min_element(a.first, a.first + a.count),
          *std::min_element(b.first, b.first + b.count)});
  }
  while (!heap_.empty() && !isTime()) {
    std::pop_heap(heap_.begin(), heap_.end(), isLater);
    const Doubt doubt = heap_.back();
    heap_.pop_back();
    refine(doubt);
  }
}

// Orders the heap: the least bound comes first; of equal bounds, the least pair and triangles,
// because they win a tie.
bool StateSearch::isLater(const Doubt& x, const Doubt& y) {
  if (x.order_m != y.order_m) return x.order_m > y.order_m;
  if (x.pair != y.pair) return x.pair > y.pair;
  return x.first_a != y.first_a ? x.first_a > y.first_a : x.first_b > y.first_b;
}

// Returns whether pairs of triangles from these on, at least low_m apart, may precede the best one.
bool StateSearch::mayPrecede(std::uint32_t pair, double low_m, std::uint32_t first_a,
                             std::uint32_t first_b) const {
  const StatePair& of = task_->pairs[pair];
  const ComparedPair least{leastCompared(low_m), first_a, first_b};
  const float apart_m = of.radii.apartM(least.distance_m);
  if (apart_m > of.margin_m) return false;
  if (apart_m != best_.apart_m) return apart_m < best_.apart_m;
  return pair != best_.pair ? pair < best_.pair : least.precedes(best_.triangles);
}

// Returns a distance of triangles [m] from which on a pair of bodies cannot have the best ones.
double StateSearch::neededM(std::uint32_t pair) const {
  const StatePair& of = task_->pairs[pair];
  return certainlyBeyond(of.radii.triangleDistanceM(least(best_.apart_m, of.margin_m)));
}

void StateSearch::push(const Doubt& doubt) {
  if (!mayPrecede(doubt.pair, doubt.low_m, doubt.first_a, doubt.first_b)) return;
  heap_.push_back(doubt);
  std::push_heap(heap_.begin(), heap_.end(), isLater);
}

// Replaces the larger one of two nodes by its children, or two leaves by their triangles.
void StateSearch::refine(const Doubt& doubt) {
  if (!mayPrecede(doubt.pair, doubt.low_m, doubt.first_a, doubt.first_b)) return;
  const StatePair& pair = task_->pairs[doubt.pair];
  const FramePair& frame = frames_[doubt.pair].pair;
  const BoxNode &a = pair.a->nodes()[doubt.a], &b = pair.b->nodes()[doubt.b];
  if (!pair.mayCount(a.part, b.part)) return;
  if (a.is_leaf && b.is_leaf) return openLeaves(doubt);
  const bool of_a = b.is_leaf || (!a.is_leaf && a.box.longestHalf() > b.box.longestHalf());
  const BoxNode &node = of_a ? a : b, &other = of_a ? b : a;
  double gaps_m[BoxNode::kLanes];
  std::uint32_t lanes =
      lanesNearer(of_a ? LaneAxes{frame.of_b, frame.of_a} : LaneAxes{frame.of_a, frame.of_b},
                  other.box, node, neededM(doubt.pair), gaps_m);
  for (; lanes != 0; lanes &= lanes - 1) {
    const int lane = __builtin_ctz(lanes);
    const double low_m = most(doubt.low_m, gaps_m[lane]);
    Doubt child = doubt;
    child.low_m = low_m;
    child.order_m = low_m - pair.radii.sum();
    (of_a ? child.a : child.b) = node.child[lane];
    (of_a ? child.first_a : child.first_b) = node.first[lane];
    push(child);
  }
}

// Only triangles whose boxes are near the other leaf's box are posed.
void StateSearch::openLeaves(const Doubt& doubt) {
  const StatePair& pair = task_->pairs[doubt.pair];
  const FramePair& frame = frames_[doubt.pair].pair;
  const BoxNode &a = pair.a->nodes()[doubt.a], &b = pair.b->nodes()[doubt.b];
  const double needed_m = neededM(doubt.pair);
  double gaps_m[BoxNode::kLanes];
  const std::uint32_t lanes_a = lanesNearer({frame.of_b, frame.of_a}, b.box, a, needed_m, gaps_m);
  const std::uint32_t lanes_b = lanesNearer({frame.of_a, frame.of_b}, a.box, b, needed_m, gaps_m);
  if (lanes_a == 0 || lanes_b == 0) return;
  leaf_a_.make(a, lanes_a, PosedBody(task_->scene.body(pair.a_id), *poses_[pair.a_id]));
  leaf_b_.make(b, lanes_b, PosedBody(task_->scene.body(pair.b_id), *poses_[pair.b_id]));
  nearLanes(leaf_a_, leaf_b_, hasDirection(doubt.pair) ? direction_ : Vec3d(), needed_m, near_);
  for (const NearLanes& near : near_) {
    const std::uint32_t triangle_a = leaf_a_.index[near.a], triangle_b = leaf_b_.index[near.b];
    if (!pair.counts(triangle_a, triangle_b)) continue;
    if (!mayPrecede(doubt.pair, most(near.low_m, doubt.low_m), triangle_a, triangle_b)) continue;
    test(doubt.pair, leaf_a_.triangle[near.a], leaf_b_.triangle[near.b], triangle_a, triangle_b,
         near.boxes_meet);
    if (isTime()) return;
  }
}

// Tests two triangles, and takes them as the best ones if they are.
void StateSearch::test(std::uint32_t pair, const Triangle& a, const Triangle& b,
                       std::uint32_t triangle_a, std::uint32_t triangle_b, bool boxes_meet) {
  const StatePair& of = task_->pairs[pair];
  if (arePlanesApart(a, b, neededM(pair))) return;
  PredicateState state{Predicates::kExact};
  const bool meet = boxes_meet && trianglesIntersect(a, b, state);
  const ComparedPair found{meet ? 0 : comparedDistance(separation(a, b)), triangle_a, triangle_b};
  const float apart_m = of.radii.apartM(found.distance_m);
  float margin_m = of.margin_m;
  if (task_->part_margins) {
    const Body& body_a = task_->scene.body(of.a_id);
    const Body& body_b = task_->scene.body(of.b_id);
    margin_m = pairMargin(body_a.marginOf(body_a.partOf(triangle_a)),
                          body_b.marginOf(body_b.partOf(triangle_b)));
  }
  if (apart_m > margin_m) return;
  const bool precedes =
      apart_m != best_.apart_m
          ? apart_m < best_.apart_m
          : (pair != best_.pair ? pair < best_.pair : found.precedes(best_.triangles));
  if (!precedes) return;
  best_ = {apart_m, pair, found};
  has_points_ = false;
}

// Returns whether the best pair is of these bodies, and its nearest points give a direction, in
// which those of other tiles lie too, more or less.
bool StateSearch::hasDirection(std::uint32_t pair) {
  if (best_.pair != pair) return false;
  if (!has_points_) {
    const NearestPair nearest = nearestPair();
    direction_ = toDouble(nearest.normal);
    has_points_ = true;
  }
  return direction_ != Vec3d();
}

// Returns the best pair, with its points.
NearestPair StateSearch::nearestPair() const {
  const StatePair& pair = task_->pairs[best_.pair];
  const BodyId a = pair.a_id, b = pair.b_id;
  const PosedBody body_a(task_->scene.body(a), *poses_[a]);
  const PosedBody body_b(task_->scene.body(b), *poses_[b]);
  const ComparedPair& triangles = best_.triangles;
  NearestPair nearest = nearestPairOf(
      body_a, body_b, {a, triangles.triangle_a, b, triangles.triangle_b}, triangles.distance_m);
  deflate(pair.radii, &nearest);
  return nearest;
}

}  // namespace deformable_contact_monitor
