// Decides one state after the other, by the trees of boxes of its bodies. Each thread of a check
// has one search.
#pragma once

#include <cstdint>
#include <vector>

#include "core/bounds/pair_radii.h"
#include "core/common/cycle_limit.h"
#include "core/common/part_table.h"
#include "core/predicates/float32_filters.h"
#include "core/rules/moved_boxes.h"
#include "core/rules/nearest.h"
#include "core/state_checker.h"
#include "core/states/box_tree.h"
#include "core/states/lane_boxes.h"
#include "core/states/posed_leaf.h"

namespace deformable_contact_monitor {

// A pair of bodies that is looked at in each state.
struct StatePair {
  BodyId a_id, b_id;
  const BoxTree *a, *b;
  float margin_m;  // the larger one of the bodies
  PairRadii radii;
  const PartTable* parts;  // null: all triangles count

  // Returns whether a pair of triangles counts.
  bool counts(std::uint32_t triangle_a, std::uint32_t triangle_b) const {
    return parts == nullptr || parts->enabled(a_id, triangle_a, b_id, triangle_b);
  }
  // Returns whether triangles of these parts may count; see BoxNode::part.
  bool mayCount(std::uint16_t part_a, std::uint16_t part_b) const {
    if (parts == nullptr || part_a == BoxNode::kSeveralParts || part_b == BoxNode::kSeveralParts) {
      return true;
    }
    return parts->pairs().enabled(parts->numberOf(a_id, static_cast<PartId>(part_a)),
                                  parts->numberOf(b_id, static_cast<PartId>(part_b)));
  }
};

// What is the same for all states of a check. All of it must live until the check ends.
struct StateTask {
  const Scene& scene;
  const StateBatch& batch;
  const StateOptions& options;
  std::vector<StatePair> pairs;  // ascending by their bodies
  bool part_margins;             // margins depend on parts
};

// One thread at a time. Results do not depend on which states were decided before.
class StateSearch {
 public:
  // Begins a check.
  void begin(const StateTask& task, const CycleLimit& limit);

  // Decides a state, and adds the pairs that touch to `pairs`, ascending, if they are asked for.
  // Returns false, and adds nothing, if the limit was over.
  bool decide(std::uint32_t state, StateAnswer* answer, std::vector<TouchingBodies>* pairs);

 private:
  // How boxes of a pair are compared, and the number of the state for which that is.
  struct Frame {
    std::uint64_t state = 0;
    FramePair pair;
  };
  struct NodePair {
    std::uint32_t a, b;
  };
  // Two nodes of the trees of a pair, whose distance is at least low_m.
  struct Doubt {
    double order_m;  // low_m minus the radii
    double low_m;
    std::uint32_t pair, a, b;
    std::uint32_t first_a, first_b;  // the least indices of their triangles
  };
  // The nearest pair of triangles so far.
  struct Best {
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    float apart_m;  // without the radii
    std::uint32_t pair;
    ComparedPair triangles;  // with their own distance
  };

  bool setPoses(std::uint32_t state);
  bool leavesFloats() const;
  bool mayBeWithin(const StatePair& pair, float distance_m) const;
  const FramePair& frameOf(std::uint32_t pair);
  Triangle posed(BodyId body, std::uint32_t triangle) const;
  bool isTime();

  bool findTouch();
  bool touches(std::uint32_t pair);
  int lanesThatMeet(std::uint32_t pair, bool of_a, const BoxNode& node, const CentredBox& other,
                    int* lanes) const;
  int trianglesThatMeet(std::uint32_t pair, bool of_a, const BoxNode& leaf, const CentredBox& other,
                        TrianglesInFrame* triangles, int* lanes) const;
  bool triangleTouches(std::uint32_t pair, bool of_a, std::uint32_t triangle,
                       const TriangleInFrame& placed, std::uint32_t other_node);
  static bool trianglesTouch(float touch_m, const Triangle& a, const PlaneFilter& plane_a,
                             const Triangle& b);
  void listTouching(std::uint32_t state, std::vector<TouchingBodies>* pairs);

  void findNearest();
  static bool isLater(const Doubt& x, const Doubt& y);
  bool mayPrecede(std::uint32_t pair, double low_m, std::uint32_t first_a,
                  std::uint32_t first_b) const;
  double neededM(std::uint32_t pair) const;
  void push(const Doubt& doubt);
  void refine(const Doubt& doubt);
  void openLeaves(const Doubt& doubt);
  void test(std::uint32_t pair, const Triangle& a, const Triangle& b, std::uint32_t triangle_a,
            std::uint32_t triangle_b, bool boxes_meet);
  bool hasDirection(std::uint32_t pair);
  NearestPair nearestPair() const;

  const StateTask* task_ = nullptr;
  const CycleLimit* limit_ = nullptr;
  bool is_over_ = false;
  std::uint32_t steps_ = 0;
  std::uint64_t state_ = 0;  // counts states; never repeats

  std::vector<const RigidTransform*> poses_;  // per body
  std::vector<bool> is_identity_;             // per body
  std::vector<const BoxTree*> trees_;         // per body; null: it is in no pair
  std::vector<Aabb> boxes_;                   // per body, scene frame [m]
  std::vector<Frame> frames_;                 // per pair
  std::vector<std::uint32_t> order_, hits_;   // of pairs: those that touch most often come first
  std::vector<NodePair> stack_;
  float growth_m_ = 0;  // boxes that are farther apart along an axis do not touch
  std::vector<std::uint32_t> below_;
  std::vector<Doubt> heap_;
  PosedLeaf leaf_a_, leaf_b_;
  std::vector<NearLanes> near_;
  Best best_;
  Vec3d direction_;         // between the best pair's nearest points; zero if they touch
  bool has_points_ = true;  // the direction is that of the present best pair
};

}  // namespace deformable_contact_monitor
