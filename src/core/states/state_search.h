// Decides one state after the other, by the trees of boxes of its bodies. Each thread of a check
// has one search.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/bounds/near_parts.h"
#include "core/bounds/pair_radii.h"
#include "core/bounds/pair_search.h"
#include "core/common/cycle_limit.h"
#include "core/rules/moved_boxes.h"
#include "core/state_checker.h"
#include "core/states/box_tree.h"

namespace deformable_contact_monitor {

// A pair of bodies that is looked at in each state.
struct StatePair {
  BodyPair bodies;  // the margin is the larger one of the bodies
  PairRadii radii;
  const BoxTree *a, *b;
};

// What is the same for all states of a check. All of it must live until the check ends.
struct StateTask {
  static constexpr std::uint32_t kNotMoved = ~std::uint32_t{0};

  const Scene& scene;
  const StateBatch& batch;
  const StateOptions& options;
  std::vector<StatePair> pairs;      // ascending by their bodies
  std::vector<std::uint32_t> place;  // per body: its place among the moved ones
  bool part_margins;                 // margins depend on parts
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
  // Two nodes of the trees of a pair, whose distance is at least low_m. They are posed if they are
  // leaves, and the bound is that of their posed tiles.
  struct Doubt {
    double order_m;  // low_m minus the radii
    double low_m;
    std::uint32_t pair, a, b;
    bool posed;
  };
  struct NodePair {
    std::uint32_t a, b;
  };
  // A tile of a moved body, and the number of the state in which it was posed.
  struct Slot {
    std::unique_ptr<PosedTile> tile;
    std::uint64_t state = 0;
  };
  // The nearest pair of triangles so far.
  struct Best {
    float apart_m;  // without the radii
    std::uint32_t pair;
    ComparedPair triangles;  // with their own distance
  };

  bool setPoses(std::uint32_t state);
  bool leavesFloats() const;
  void makeFrames();
  const PosedTile& tileOf(BodyId body, const BoxTree& tree, std::uint32_t tile);

  bool findTouch();
  bool touches(std::uint32_t pair);
  bool tilesTouch(const StatePair& pair, std::uint32_t tile_a, std::uint32_t tile_b);
  void listTouching(std::uint32_t state, std::vector<TouchingBodies>* pairs);

  void findNearest();
  bool isLater(const Doubt& x, const Doubt& y) const;
  bool mayPrecede(std::uint32_t pair, double low_m, std::uint32_t first_a,
                  std::uint32_t first_b) const;
  double neededM(std::uint32_t pair) const;
  void push(const Doubt& doubt);
  void pushNodes(std::uint32_t pair, std::uint32_t a, std::uint32_t b);
  void refine(const Doubt& doubt);
  void openTiles(const Doubt& doubt);
  void testSomeTriangles(std::uint32_t pair, const PosedTile& a, const PosedTile& b);
  void test(std::uint32_t pair, const Triangle& a, const Triangle& b, std::uint32_t triangle_a,
            std::uint32_t triangle_b, bool boxes_meet);
  bool hasDirection(std::uint32_t pair);
  NearestPair nearestPair() const;

  // Returns whether to split the first of two nodes rather than the second.
  static bool splitsFirst(const BoxNode& a, const BoxNode& b);
  bool isTime();

  const StateTask* task_ = nullptr;
  const CycleLimit* limit_ = nullptr;
  bool is_over_ = false;
  std::uint32_t steps_ = 0;

  std::uint64_t state_ = 0;                   // counts states; never repeats
  std::vector<const RigidTransform*> poses_;  // per body
  std::vector<FramePair<double>> frames_;     // per pair
  std::vector<std::vector<Slot>> slots_;      // per moved body and tile
  std::vector<std::uint32_t> order_, hits_;   // of pairs: those that touch most often come first
  std::vector<NodePair> stack_;
  std::vector<Doubt> heap_;
  std::vector<NearTriangles> triangles_;
  Best best_;
  Vec3d direction_;         // between the best pair's nearest points; zero if they touch
  bool has_points_ = true;  // the direction is that of the present best pair
};

}  // namespace deformable_contact_monitor
