#include "core/states/state_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/common/posed_body.h"
#include "core/predicates/narrow_phase.h"
#include "core/rules/margins.h"
#include "core/states/state_input.h"

namespace deformable_contact_monitor {
namespace {

// Returns the least number that is not below a distance of float axes for which boxes along one
// axis are certainly farther apart than touch_m [m].
float growthOf(const FramePair& frame, float touch_m) {
  if (touch_m == 0) return 0;
  const double scale = std::sqrt(std::min(frame.of_a.scale2, frame.of_b.scale2));
  return static_cast<float>(certainlyBeyond(touch_m) / scale * (1 + 1e-6));
}

// Returns whether a box of posed vertices has all of them, as none became infinite.
bool isFiniteBox(const Aabb& box) { return isFinite(box.min) && isFinite(box.max); }

// Lists lanes, given by their bits, the least gap first. Returns how many they are.
int lanesByGap(std::uint32_t bits, const float* gaps, int* lanes) {
  int count = 0;
  for (; bits != 0; bits &= bits - 1) {
    const int lane = __builtin_ctz(bits);
    int i = count++;
    for (; i > 0 && gaps[lanes[i - 1]] > gaps[lane]; --i) lanes[i] = lanes[i - 1];
    lanes[i] = lane;
  }
  return count;
}

}  // namespace

void StateSearch::begin(const StateTask& task, const CycleLimit& limit) {
  task_ = &task;
  limit_ = &limit;
  is_over_ = false;
  poses_.clear();
  is_identity_.clear();
  for (const Body& body : task.scene.bodies()) {
    poses_.push_back(&body.pose);
    is_identity_.push_back(body.pose.isIdentity());
  }
  trees_.assign(task.scene.bodyCount(), nullptr);
  boxes_.assign(task.scene.bodyCount(), Aabb());
  for (const StatePair& pair : task.pairs) {
    trees_[pair.a_id] = pair.a;
    trees_[pair.b_id] = pair.b;
  }
  for (BodyId id = 0; id < trees_.size(); ++id) {
    if (trees_[id] != nullptr)
      boxes_[id] = posedBox(trees_[id]->box(), *poses_[id], is_identity_[id]);
  }
  ++state_;
  frames_.resize(task.pairs.size());
  order_.resize(task.pairs.size());
  std::iota(order_.begin(), order_.end(), 0U);
  hits_.assign(task.pairs.size(), 0);
}

bool StateSearch::decide(std::uint32_t state, StateAnswer* answer,
                         std::vector<TouchingBodies>* pairs) {
  if (!setPoses(state)) return true;
  ++state_;
  const std::size_t listed = pairs->size();
  const StateOptions& options = task_->options;
  bool touch = false, near = false;
  best_ = {INFINITY, Best::kNone, {INFINITY, Best::kNone, Best::kNone}};
  if (options.nearest) {
    findNearest();
    touch = best_.apart_m == 0;
    near = best_.pair != Best::kNone;
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
    is_identity_[moved[i]] = poses[i].isIdentity();
    const BoxTree* const tree = trees_[moved[i]];
    if (tree != nullptr) boxes_[moved[i]] = posedBox(tree->box(), poses[i], is_identity_[moved[i]]);
  }
  return true;
}

bool StateSearch::leavesFloats() const {
  const auto leaves = [this](BodyId id) {
    if (boxes_[id].empty() || isFiniteBox(boxes_[id])) return false;
    return deformable_contact_monitor::leavesFloats(task_->scene.body(id), *poses_[id]);
  };
  return std::any_of(task_->pairs.begin(), task_->pairs.end(),
                     [&](const StatePair& pair) { return leaves(pair.a_id) || leaves(pair.b_id); });
}

// Returns whether the distance of two bodies, rounded to float32, may be at most `distance_m`, by
// boxes in the scene frame.
bool StateSearch::mayBeWithin(const StatePair& pair, float distance_m) const {
  if (pair.a->empty() || pair.b->empty()) return false;
  if (distance_m > 0) distance_m = std::nextafter(distance_m, INFINITY);
  const Aabb &a = boxes_[pair.a_id], &b = boxes_[pair.b_id];
  return !isFiniteBox(a) || !isFiniteBox(b) || !areApart(a, b, distance_m);
}

// Returns how the boxes of a pair are compared in this state.
const FramePair& StateSearch::frameOf(std::uint32_t pair_index) {
  Frame& frame = frames_[pair_index];
  if (frame.state == state_) return frame.pair;
  const StatePair& pair = task_->pairs[pair_index];
  frame.pair = FramePair::of(*poses_[pair.a_id], pair.a->nodes()[0].box, *poses_[pair.b_id],
                             pair.b->nodes()[0].box);
  frame.state = state_;
  return frame.pair;
}

Triangle StateSearch::posed(BodyId body, std::uint32_t triangle) const {
  const TriangleMesh& mesh = task_->scene.body(body).mesh;
  const std::uint32_t* const corner = mesh.triangles.data() + 3 * std::size_t{triangle};
  const auto vertex = [&](int k) {
    return posedVertex(*poses_[body], is_identity_[body], mesh.vertex(corner[k]));
  };
  return {{vertex(0), vertex(1), vertex(2)}};
}

// Polls the limit once in some steps of about a microsecond at most.
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
    const StatePair& pair = task_->pairs[i];
    if (touches(i)) pairs->push_back({state, pair.a_id, pair.b_id});
  }
}

// Returns whether two bodies touch; unspecified if it is time to stop.
bool StateSearch::touches(std::uint32_t pair_index) {
  const StatePair& pair = task_->pairs[pair_index];
  if (!mayBeWithin(pair, pair.radii.touch_m)) return false;
  const std::vector<BoxNode>&a = pair.a->nodes(), &b = pair.b->nodes();
  growth_m_ = growthOf(frameOf(pair_index), pair.radii.touch_m);
  stack_.assign(1, {0, 0});
  while (!stack_.empty()) {
    if (isTime()) return false;
    const NodePair nodes = stack_.back();
    stack_.pop_back();
    const BoxNode &node_a = a[nodes.a], &node_b = b[nodes.b];
    if (!pair.mayCount(node_a.part, node_b.part)) continue;
    // The larger one is split. A leaf is split into its triangles, which are compared with all
    // that is below the other node, because their planes leave little of it.
    const bool of_a = node_a.box.longestHalf() > node_b.box.longestHalf();
    const BoxNode &split = of_a ? node_a : node_b, &other = of_a ? node_b : node_a;
    int order[BoxNode::kLanes];
    if (!split.is_leaf) {
      // The stack gives back last what it got first.
      for (int i = lanesThatMeet(pair_index, of_a, split, other.box, order); i > 0; --i) {
        const std::uint32_t child = split.child[order[i - 1]];
        stack_.push_back(of_a ? NodePair{child, nodes.b} : NodePair{nodes.a, child});
      }
      continue;
    }
    TrianglesInFrame triangles;
    const int count = trianglesThatMeet(pair_index, of_a, split, other.box, &triangles, order);
    for (int i = 0; i < count; ++i) {
      if (triangleTouches(pair_index, of_a, split.child[order[i]], triangles.at(order[i]),
                          of_a ? nodes.b : nodes.a)) {
        return true;
      }
    }
  }
  return false;
}

// Lists the children of a node of a, or of b, whose boxes may touch a box of the other body, those
// that overlap most first. Returns how many they are.
int StateSearch::lanesThatMeet(std::uint32_t pair_index, bool of_a, const BoxNode& node,
                               const CentredBox& other, int* lanes) const {
  const FramePair& frame = frames_[pair_index].pair;
  const LaneAxes axes = of_a ? LaneAxes{frame.of_b, frame.of_a} : LaneAxes{frame.of_a, frame.of_b};
  float gaps[BoxNode::kLanes];
  return lanesByGap(lanesWithin(axes, other, node, growth_m_, gaps) & node.used, gaps, lanes);
}

// Does the same with the triangles of a leaf, and tells where they are in the other body's frame.
int StateSearch::trianglesThatMeet(std::uint32_t pair_index, bool of_a, const BoxNode& leaf,
                                   const CentredBox& other, TrianglesInFrame* triangles,
                                   int* lanes) const {
  const StatePair& pair = task_->pairs[pair_index];
  const FramePair& frame = frames_[pair_index].pair;
  float gaps[BoxNode::kLanes];
  const std::uint32_t bits =
      placeTriangles(of_a ? frame.of_b : frame.of_a, (of_a ? pair.a : pair.b)->corners(leaf),
                     growth_m_, other, *triangles, gaps);
  return lanesByGap(bits & leaf.used, gaps, lanes);
}

// Returns whether a triangle of a, or of b, touches one below a node of the other body.
bool StateSearch::triangleTouches(std::uint32_t pair_index, bool of_a, std::uint32_t triangle,
                                  const TriangleInFrame& placed, std::uint32_t other_node) {
  const StatePair& pair = task_->pairs[pair_index];
  const BodyId id = of_a ? pair.a_id : pair.b_id, other_id = of_a ? pair.b_id : pair.a_id;
  Triangle own;
  PlaneFilter plane;
  bool is_posed = false;
  const std::vector<BoxNode>& nodes = (of_a ? pair.b : pair.a)->nodes();
  below_.assign(1, other_node);
  while (!below_.empty()) {
    const BoxNode& node = nodes[below_.back()];
    below_.pop_back();
    if (isTime()) return false;
    for (std::uint32_t lanes = lanesWithin(placed, node) & node.used; lanes != 0;
         lanes &= lanes - 1) {
      const std::uint32_t child = node.child[__builtin_ctz(lanes)];
      if (!node.is_leaf) {
        below_.push_back(child);
      } else if (of_a ? pair.counts(triangle, child) : pair.counts(child, triangle)) {
        if (!is_posed) {
          own = posed(id, triangle);
          if (!isFinite(own)) return false;
          plane = PlaneFilter(own);
          is_posed = true;
        }
        if (trianglesTouch(pair.radii.touch_m, own, plane, posed(other_id, child))) return true;
      }
    }
  }
  return false;
}

// Returns whether two triangles touch. The first one is finite.
bool StateSearch::trianglesTouch(float touch_m, const Triangle& a, const PlaneFilter& plane_a,
                                 const Triangle& b) {
  if (!isFinite(b)) return false;
  if (intersects(boxOf(a), boxOf(b))) {
    PairFacts facts;
    PredicateState state{Predicates::kExact};
    int sides = 0;
    for (int i = 0; i < 3; ++i) sides += facts.sides.b[i] = plane_a.side(b.v[i]);
    if (sides != 3 && sides != -3) {
      const PlaneFilter plane_b(b);
      sides = 0;
      for (int i = 0; i < 3; ++i) sides += facts.sides.a[i] = plane_b.side(a.v[i]);
      if (sides != 3 && sides != -3 && candidateVerdict(a, b, facts, state).contact) return true;
    }
  }
  if (touch_m == 0 || arePlanesApart(a, b, certainlyBeyond(touch_m))) return false;
  return comparedDistance(separation(a, b)) <= touch_m;
}

}  // namespace deformable_contact_monitor
