// A tree of boxes over a body's triangles, in the body's own frame. It depends on the vertices
// only, so it serves all states and all poses of the body.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/halving.h"
#include "core/predicates/triangle.h"
#include "core/rules/moved_boxes.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// A node with up to eight children, which are compared with another box at once. Of a leaf, the
// children are triangles; of other nodes, nodes that come later in the list.
struct BoxNode {
  static constexpr std::size_t kLanes = 8;
  static constexpr std::uint16_t kSeveralParts = 256;

  float centre[3][kLanes], half[3][kLanes];  // of the children's boxes [m]; 0 for lanes not in use
  std::uint32_t child[kLanes];
  std::uint32_t first[kLanes];  // the least index of a triangle below
  std::uint32_t count;          // of children
  std::uint32_t leaf;           // of a leaf: its number
  std::uint32_t used;           // bits of the children that have triangles with finite vertices
  std::uint16_t part;           // the part of all triangles below, or kSeveralParts
  bool is_leaf;
  CentredBox box;  // of all children

  CentredBox boxOf(std::size_t lane) const {
    return {{centre[0][lane], centre[1][lane], centre[2][lane]},
            {half[0][lane], half[1][lane], half[2][lane]}};
  }
};

// The corners of a leaf's triangles in the body's own frame, by corner and axis [m]. Those of lanes
// that are not in use are 0.
struct LeafCorners {
  float at[3][3][BoxNode::kLanes];
};

class BoxTree {
 public:
  // Begins a check. Returns false if the limit was over; then the object is of no use in this
  // check. The body's vertices must be on the host.
  bool update(const Body& body, const CycleLimit& limit);

  // Any number of threads may call the following functions.
  // Returns whether no triangle has finite vertices. Then there may be no node.
  bool empty() const { return box_.empty(); }
  // Returns the nodes, the root first.
  const std::vector<BoxNode>& nodes() const { return nodes_; }
  // Returns the corners of a leaf.
  const LeafCorners& corners(const BoxNode& leaf) const { return corners_[leaf.leaf]; }
  // Returns the box of all triangles with finite vertices [m].
  const Aabb& box() const { return box_; }

 private:
  void order(const Body& body, const CycleLimit& limit);
  std::uint32_t split(PlacedTriangle* first, PlacedTriangle* last, const CycleLimit& limit);
  void fit(const Body& body);
  void fitNode(const Body& body, BoxNode& node, Aabb& box);

  std::vector<BoxNode> nodes_;
  std::vector<LeafCorners> corners_;
  std::vector<Aabb> boxes_;  // of the nodes
  Aabb box_;
  double ordered_size_ = 0, size_ = 0;  // of the leaves: when they were ordered, and now
  std::uint64_t topology_revision_ = 0, vertices_revision_ = 0, parts_revision_ = 0;
};

}  // namespace deformable_contact_monitor
