#include "core/states/state_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/common/contact_geometry.h"
#include "core/common/posed_body.h"
#include "core/predicates/narrow_phase.h"
#include "core/rules/margins.h"
#include "core/states/state_input.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kNoPair = ~std::uint32_t{0};

// Returns the square of a distance, rounded up.
double squaredUp(double distance_m) { return distance_m * distance_m * (1 + 1e-12); }

}  // namespace

void StateSearch::begin(const StateTask& task, const CycleLimit& limit) {
  task_ = &task;
  limit_ = &limit;
  is_over_ = false;
  poses_.clear();
  for (const Body& body : task.scene.bodies()) poses_.push_back(&body.pose);
  slots_.resize(task.batch.moved.size());
  for (std::size_t i = 0; i < slots_.size(); ++i) slots_[i].clear();
  for (const StatePair& pair : task.pairs) {
    const std::uint32_t a = task.place[pair.bodies.a_id], b = task.place[pair.bodies.b_id];
    if (a != StateTask::kNotMoved) slots_[a].resize(pair.a->tiles().tileCount());
    if (b != StateTask::kNotMoved) slots_[b].resize(pair.b->tiles().tileCount());
  }
  frames_.resize(task.pairs.size());
  order_.resize(task.pairs.size());
  std::iota(order_.begin(), order_.end(), 0U);
  hits_.assign(task.pairs.size(), 0);
}

bool StateSearch::decide(std::uint32_t state, StateAnswer* answer,
                         std::vector<TouchingBodies>* pairs) {
  ++state_;
  if (!setPoses(state)) return true;
  makeFrames();
  const std::size_t listed = pairs->size();
  const StateOptions& options = task_->options;
  bool touch = false, near = false;
  best_ = {INFINITY, kNoPair, {INFINITY, kNoPair, kNoPair}};
  if (options.nearest) {
    findNearest();
    touch = best_.apart_m == 0;
    near = best_.pair != kNoPair;
    if (touch && options.pairs) listTouching(state, pairs);
  } else if (options.pairs) {
    listTouching(state, pairs);
    touch = pairs->size() > listed;
  } else {
    touch = findTouch();
  }
  if (is_over_) {
    pairs->resize(listed);
    return false;
  }
  if (!touch && leavesFloats()) return true;
  answer->decision =
      touch ? PairDecision::kContact : (near ? PairDecision::kNear : PairDecision::kNone);
  if (near) answer->nearest = nearestPair();
  return true;
}

// Returns false if a pose is not finite.
bool StateSearch::setPoses(std::uint32_t state) {
  const std::vector<BodyId>& moved = task_->batch.moved;
  const RigidTransform* const poses = task_->batch.poses + std::size_t{state} * moved.size();
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (!isFinite(poses[i])) return false;
    poses_[moved[i]] = poses + i;
  }
  return true;
}

bool StateSearch::leavesFloats() const {
  const auto leaves = [this](BodyId id, const BoxTree& tree) {
    const RigidTransform& pose = *poses_[id];
    const Aabb box = tree.nodes().empty() ? Aabb() : posedBox(tree.box(), pose, pose.isIdentity());
    if (box.empty() || (isFinite(box.min) && isFinite(box.max))) return false;
    return deformable_contact_monitor::leavesFloats(task_->scene.body(id), pose);
  };
  return std::any_of(task_->pairs.begin(), task_->pairs.end(), [&](const StatePair& pair) {
    return leaves(pair.bodies.a_id, *pair.a) || leaves(pair.bodies.b_id, *pair.b);
  });
}

void StateSearch::makeFrames() {
  for (std::size_t i = 0; i < task_->pairs.size(); ++i) {
    const StatePair& pair = task_->pairs[i];
    if (pair.a->nodes().empty() || pair.b->nodes().empty()) continue;
    frames_[i] = FramePair<double>::of(*poses_[pair.bodies.a_id], pair.a->nodes()[0].box,
                                       *poses_[pair.bodies.b_id], pair.b->nodes()[0].box);
  }
}

// Returns a tile with posed vertices. Tiles of bodies that are not moved are shared by all threads.
const PosedTile& StateSearch::tileOf(BodyId body, const BoxTree& tree, std::uint32_t tile) {
  const std::uint32_t place = task_->place[body];
  if (place == StateTask::kNotMoved) return tree.tiles().tile(tile);
  Slot& slot = slots_[place][tile];
  if (slot.tile == nullptr) slot.tile = std::make_unique<PosedTile>();
  if (slot.state != state_) tree.tiles().makeTile(tile, *poses_[body], *slot.tile);
  slot.state = state_;
  return *slot.tile;
}

bool StateSearch::splitsFirst(const BoxNode& a, const BoxNode& b) {
  if (a.isLeaf() || b.isLeaf()) return b.isLeaf();
  const auto size = [](const CentredBox& box) {
    return most(most(box.half[0], box.half[1]), box.half[2]);
  };
  return size(a.box) > size(b.box);
}

// Polls the limit once in some steps of about a microsecond.
bool StateSearch::isTime() {
  constexpr std::uint32_t kSteps = 64;
  if (++steps_ % kSteps == 0 && limit_->over()) is_over_ = true;
  return is_over_;
}

// Returns whether some pair touches.
bool StateSearch::findTouch() {
  for (std::size_t i = 0; i < order_.size(); ++i) {
    if (!touches(order_[i])) continue;
    // Pairs that touch often come first, as later states may be decided by them.
    ++hits_[order_[i]];
    for (; i > 0 && hits_[order_[i]] > hits_[order_[i - 1]]; --i) {
      std::swap(order_[i], order_[i - 1]);
    }
    return true;
  }
  return false;
}

void StateSearch::listTouching(std::uint32_t state, std::vector<TouchingBodies>* pairs) {
  for (std::uint32_t i = 0; i < task_->pairs.size(); ++i) {
    const BodyPair& bodies = task_->pairs[i].bodies;
    if (touches(i)) pairs->push_back({state, bodies.a_id, bodies.b_id});
  }
}

// Returns whether two bodies touch; unspecified if it is time to stop.
bool StateSearch::touches(std::uint32_t pair_index) {
  const StatePair& pair = task_->pairs[pair_index];
  const std::vector<BoxNode>&a = pair.a->nodes(), &b = pair.b->nodes();
  if (a.empty() || b.empty()) return false;
  const FramePair<double>& frame = frames_[pair_index];
  const double needed2 = squaredUp(certainlyBeyond(pair.radii.touch_m));
  stack_.assign(1, {0, 0});
  while (!stack_.empty()) {
    if (isTime()) return false;
    const NodePair nodes = stack_.back();
    stack_.pop_back();
    const BoxNode &node_a = a[nodes.a], &node_b = b[nodes.b];
    if (frame.squaredGap(node_a.box, node_b.box, needed2) >= needed2) continue;
    if (!pair.bodies.mayCount(node_a.part, node_b.part)) continue;
    if (node_a.isLeaf() && node_b.isLeaf()) {
      if (tilesTouch(pair, node_a.tile, node_b.tile)) return true;
    } else if (splitsFirst(node_a, node_b)) {
      stack_.push_back({node_a.child, nodes.b});
      stack_.push_back({node_a.child + 1, nodes.b});
    } else {
      stack_.push_back({nodes.a, node_b.child});
      stack_.push_back({nodes.a, node_b.child + 1});
    }
  }
  return false;
}

bool StateSearch::tilesTouch(const StatePair& pair, std::uint32_t tile_a, std::uint32_t tile_b) {
  const PosedTile& a = tileOf(pair.bodies.a_id, *pair.a, tile_a);
  const PosedTile& b = tileOf(pair.bodies.b_id, *pair.b, tile_b);
  const float touch_m = pair.radii.touch_m;
  const double needed_m = certainlyBeyond(touch_m);
  if (lowerGap(a, b) >= needed_m) return false;
  nearTriangles(a, b, needed_m, triangles_);
  for (const NearTriangles& near : triangles_) {
    if (!pair.bodies.counts(a.triangle[near.a], b.triangle[near.b])) continue;
    const Triangle triangle_a = a.posed(near.a), triangle_b = b.posed(near.b);
    if (near.boxes_meet) {
      PairFacts facts;
      PredicateState state{Predicates::kExact};
      if (isCandidate(triangle_a, triangle_b, facts) &&
          candidateVerdict(triangle_a, triangle_b, facts, state).contact) {
        return true;
      }
    }
    if (touch_m == 0 || arePlanesApart(triangle_a, triangle_b, needed_m)) continue;
    if (comparedDistance(separation(triangle_a, triangle_b)) <= touch_m) return true;
  }
  return false;
}

// Searches all pairs of bodies at once, best first, because only the nearest of all is asked for.
void StateSearch::findNearest() {
  heap_.clear();
  for (std::uint32_t i = 0; i < task_->pairs.size(); ++i) {
    const StatePair& pair = task_->pairs[i];
    if (!pair.a->nodes().empty() && !pair.b->nodes().empty()) pushNodes(i, 0, 0);
  }
  while (!heap_.empty() && !isTime()) {
    std::pop_heap(heap_.begin(), heap_.end(),
                  [this](const Doubt& x, const Doubt& y) { return isLater(x, y); });
    const Doubt doubt = heap_.back();
    heap_.pop_back();
    refine(doubt);
  }
}

// Orders the heap: the least bound comes first; of equal bounds, posed tiles, and then the least
// pair, because it wins a tie.
bool StateSearch::isLater(const Doubt& x, const Doubt& y) const {
  if (x.order_m != y.order_m) return x.order_m > y.order_m;
  if (x.pair != y.pair) return x.pair > y.pair;
  if (x.posed != y.posed) return y.posed;
  const StatePair& pair = task_->pairs[x.pair];
  const auto first_a = [&](const Doubt& d) { return pair.a->nodes()[d.a].first_triangle; };
  const auto first_b = [&](const Doubt& d) { return pair.b->nodes()[d.b].first_triangle; };
  if (first_a(x) != first_a(y)) return first_a(x) > first_a(y);
  return first_b(x) > first_b(y);
}

// Returns whether pairs of triangles from these on, at least low_m apart, may precede the best one.
bool StateSearch::mayPrecede(std::uint32_t pair, double low_m, std::uint32_t first_a,
                             std::uint32_t first_b) const {
  const StatePair& of = task_->pairs[pair];
  const ComparedPair least{leastCompared(low_m), first_a, first_b};
  const float apart_m = of.radii.apartM(least.distance_m);
  if (apart_m > of.bodies.margin_m) return false;
  if (apart_m != best_.apart_m) return apart_m < best_.apart_m;
  return pair != best_.pair ? pair < best_.pair : least.precedes(best_.triangles);
}

// Returns a distance of triangles [m] from which on a pair of bodies cannot have the best ones.
double StateSearch::neededM(std::uint32_t pair) const {
  const StatePair& of = task_->pairs[pair];
  return certainlyBeyond(of.radii.triangleDistanceM(least(best_.apart_m, of.bodies.margin_m)));
}

void StateSearch::push(const Doubt& doubt) {
  const StatePair& pair = task_->pairs[doubt.pair];
  if (!mayPrecede(doubt.pair, doubt.low_m, pair.a->nodes()[doubt.a].first_triangle,
                  pair.b->nodes()[doubt.b].first_triangle)) {
    return;
  }
  heap_.push_back(doubt);
  std::push_heap(heap_.begin(), heap_.end(),
                 [this](const Doubt& x, const Doubt& y) { return isLater(x, y); });
}

void StateSearch::pushNodes(std::uint32_t pair, std::uint32_t a, std::uint32_t b) {
  const StatePair& of = task_->pairs[pair];
  const BoxNode &node_a = of.a->nodes()[a], &node_b = of.b->nodes()[b];
  if (!of.bodies.mayCount(node_a.part, node_b.part)) return;
  const double squared = frames_[pair].squaredGap(node_a.box, node_b.box, INFINITY);
  const double low_m = std::sqrt(squared) * (1 - 1e-14);
  push({low_m - of.radii.sum(), low_m, pair, a, b, false});
}

// Replaces two nodes by their children, or by their tiles and these by their triangles.
void StateSearch::refine(const Doubt& doubt) {
  const StatePair& pair = task_->pairs[doubt.pair];
  const BoxNode &a = pair.a->nodes()[doubt.a], &b = pair.b->nodes()[doubt.b];
  if (!mayPrecede(doubt.pair, doubt.low_m, a.first_triangle, b.first_triangle)) return;
  if (doubt.posed) return openTiles(doubt);
  if (a.isLeaf() && b.isLeaf()) {
    Doubt posed = doubt;
    posed.posed = true;
    const PosedTile& tile_a = tileOf(pair.bodies.a_id, *pair.a, a.tile);
    const PosedTile& tile_b = tileOf(pair.bodies.b_id, *pair.b, b.tile);
    if (tile_a.count == 0 || tile_b.count == 0) return;  // all triangles were rejected
    posed.low_m = most(doubt.low_m, lowerGap(tile_a, tile_b));
    if (!mayPrecede(doubt.pair, posed.low_m, a.first_triangle, b.first_triangle)) return;
    if (hasDirection(doubt.pair)) {
      posed.low_m = most(posed.low_m, lowerGapAlong(direction_, tile_a, tile_b));
    }
    posed.order_m = posed.low_m - pair.radii.sum();
    return push(posed);
  }
  const bool first = splitsFirst(a, b);
  for (std::uint32_t i = 0; i < 2; ++i) {
    pushNodes(doubt.pair, first ? a.child + i : doubt.a, first ? doubt.b : b.child + i);
  }
}

void StateSearch::openTiles(const Doubt& doubt) {
  const StatePair& pair = task_->pairs[doubt.pair];
  const PosedTile& a = tileOf(pair.bodies.a_id, *pair.a, pair.a->nodes()[doubt.a].tile);
  const PosedTile& b = tileOf(pair.bodies.b_id, *pair.b, pair.b->nodes()[doubt.b].tile);
  if (best_.pair != doubt.pair) testSomeTriangles(doubt.pair, a, b);
  if (hasDirection(doubt.pair)) {
    nearTrianglesAlong(direction_, a, b, neededM(doubt.pair), triangles_);
  } else {
    nearTriangles(a, b, neededM(doubt.pair), triangles_);
  }
  for (const NearTriangles& near : triangles_) {
    const std::uint32_t triangle_a = a.triangle[near.a], triangle_b = b.triangle[near.b];
    if (!pair.bodies.counts(triangle_a, triangle_b)) continue;
    if (!mayPrecede(doubt.pair, most(near.low_m, doubt.low_m), triangle_a, triangle_b)) continue;
    test(doubt.pair, a.posed(near.a), b.posed(near.b), triangle_a, triangle_b, near.boxes_meet);
    if (isTime()) return;
  }
}

// Tests two triangles of two tiles that are likely to be near each other, so that the best pair and
// its direction leave few of the others.
void StateSearch::testSomeTriangles(std::uint32_t pair, const PosedTile& a, const PosedTile& b) {
  const auto nearestTo = [](const PosedTile& tile, const Vec3f& point) {
    std::size_t nearest = 0;
    float least2 = INFINITY;
    for (std::size_t t = 0; t < tile.count; ++t) {
      const Vec3f low{tile.low[0][t], tile.low[1][t], tile.low[2][t]};
      const Vec3f high{tile.high[0][t], tile.high[1][t], tile.high[2][t]};
      const Vec3f off = low * 0.5F + high * 0.5F - point;
      if (dot(off, off) >= least2) continue;
      least2 = dot(off, off);
      nearest = t;
    }
    return nearest;
  };
  const auto middle = [](const PosedTile& tile, std::size_t t) {
    const Triangle triangle = tile.posed(t);
    return (triangle.v[0] + triangle.v[1] + triangle.v[2]) * (1.0F / 3);
  };
  std::size_t t_a = nearestTo(a, b.box.min * 0.5F + b.box.max * 0.5F);
  const std::size_t t_b = nearestTo(b, middle(a, t_a));
  t_a = nearestTo(a, middle(b, t_b));
  if (!task_->pairs[pair].bodies.counts(a.triangle[t_a], b.triangle[t_b])) return;
  const Triangle triangle_a = a.posed(t_a), triangle_b = b.posed(t_b);
  test(pair, triangle_a, triangle_b, a.triangle[t_a], b.triangle[t_b],
       intersects(boxOf(triangle_a), boxOf(triangle_b)));
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
  float margin_m = of.bodies.margin_m;
  if (task_->part_margins) {
    const Body& body_a = task_->scene.body(of.bodies.a_id);
    const Body& body_b = task_->scene.body(of.bodies.b_id);
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
  const BodyId a = pair.bodies.a_id, b = pair.bodies.b_id;
  const PosedBody body_a(task_->scene.body(a), *poses_[a]);
  const PosedBody body_b(task_->scene.body(b), *poses_[b]);
  const ComparedPair& triangles = best_.triangles;
  NearestPair nearest = nearestPairOf(
      body_a, body_b, {a, triangles.triangle_a, b, triangles.triangle_b}, triangles.distance_m);
  deflate(pair.radii, &nearest);
  return nearest;
}

}  // namespace deformable_contact_monitor
