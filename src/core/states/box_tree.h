// A tree of boxes over a body's tiles, in the body's own frame. It depends on the vertices only, so
// it serves all states and all poses of the body.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/bounds/body_tiles.h"
#include "core/common/cycle_limit.h"
#include "core/rules/moved_boxes.h"
#include "core/scene.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// A node of the tree. The two children of an inner node follow each other.
struct BoxNode {
  static constexpr std::uint32_t kNoTile = ~std::uint32_t{0};

  CentredBox box;
  std::uint32_t tile;            // of a leaf; kNoTile: the node has children
  std::uint32_t child;           // the first one; of a leaf: 0
  std::uint32_t first_triangle;  // the least index below it
  std::uint32_t part;            // as BodyTiles::partOfTile()

  bool isLeaf() const { return tile != kNoTile; }
};

// The tiles of a body, and the tree over them. It is kept as long as the vertices are the same.
class BoxTree {
 public:
  // Begins a check, on the threads of this TBB arena. Returns false if the limit was over; then the
  // object is of no use in this check. The body must live, unchanged, until the check ends, and its
  // vertices must be on the host.
  bool update(const Body& body, const CycleLimit& limit);

  // Any number of threads may call the following functions.
  const BodyTiles& tiles() const { return tiles_; }
  // Returns the box of all finite vertices, in the body's own frame [m].
  const Aabb& box() const { return box_; }
  // Returns the nodes, the root first. Empty if the body has no triangle with finite vertices.
  const std::vector<BoxNode>& nodes() const { return nodes_; }

 private:
  bool findTiling(const Body& body, const CycleLimit& limit);
  void build();
  void split(std::uint32_t node, std::uint32_t* first, std::uint32_t* last);

  BodyTiles tiles_;
  std::shared_ptr<const Tiling> tiling_;
  bool is_by_surface_ = false;
  std::uint64_t topology_revision_ = 0, vertices_revision_ = 0, parts_revision_ = 0;
  Aabb box_;
  std::vector<BoxNode> nodes_;
};

}  // namespace deformable_contact_monitor
