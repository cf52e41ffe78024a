#include "core/states/box_tree.h"

#include <algorithm>

namespace deformable_contact_monitor {

bool BoxTree::update(const Body& body, const CycleLimit& limit) {
  const bool same_vertices = vertices_revision_ == body.vertices_revision;
  if (!findTiling(body, limit)) return false;
  if (!tiles_.update(body, tiling_, limit)) {
    vertices_revision_ = 0;
    return false;
  }
  if (!same_vertices || parts_revision_ != body.parts_revision) build();
  vertices_revision_ = body.vertices_revision;
  parts_revision_ = body.parts_revision;
  return true;
}

// Most meshes are rigid, and tiles by position are made fast, and are good for good. Once vertices
// change while the triangles stay, the mesh deforms, and gets tiles by surface.
bool BoxTree::findTiling(const Body& body, const CycleLimit& limit) {
  if (tiling_ == nullptr || topology_revision_ != body.topology_revision) {
    if (limit.over()) return false;
    tiling_ = std::make_shared<const Tiling>(tilingByPosition(body.mesh));
    is_by_surface_ = false;
  } else if (!is_by_surface_ && vertices_revision_ != body.vertices_revision) {
    if (limit.over()) return false;
    tiling_ = std::make_shared<const Tiling>(tilingBySurface(body.mesh));
    is_by_surface_ = true;
  }
  topology_revision_ = body.topology_revision;
  return true;
}

void BoxTree::build() {
  std::vector<std::uint32_t> tiles;
  for (std::uint32_t tile = 0; tile < tiles_.tileCount(); ++tile) {
    if (!tiles_.receivedTileBox(tile).empty()) tiles.push_back(tile);
  }
  box_ = Aabb();
  for (const std::uint32_t tile : tiles) box_.include(tiles_.receivedTileBox(tile));
  nodes_.clear();
  if (tiles.empty()) return;
  nodes_.reserve(2 * tiles.size());
  nodes_.emplace_back();
  split(0, tiles.data(), tiles.data() + tiles.size());
}

// Makes a node of tiles: a leaf of one, or else two halves along the longest side of its box.
void BoxTree::split(std::uint32_t node, std::uint32_t* first, std::uint32_t* last) {
  Aabb box;
  std::uint32_t first_triangle = BoxNode::kNoTile, part = tiles_.partOfTile(*first);
  for (const std::uint32_t* tile = first; tile != last; ++tile) {
    box.include(tiles_.receivedTileBox(*tile));
    first_triangle = std::min(first_triangle, tiles_.firstOfTile(*tile));
    if (tiles_.partOfTile(*tile) != part) part = BodyTiles::kSeveralParts;
  }
  const bool is_leaf = last - first == 1;
  const auto child = static_cast<std::uint32_t>(is_leaf ? 0 : nodes_.size());
  nodes_[node] = {CentredBox::of(box), is_leaf ? *first : BoxNode::kNoTile, child, first_triangle,
                  part};
  if (is_leaf) return;
  int side = 0;
  for (int k = 1; k < 3; ++k) {
    if (nodes_[node].box.half[k] > nodes_[node].box.half[side]) side = k;
  }
  std::uint32_t* const middle = first + (last - first) / 2;
  std::nth_element(first, middle, last, [this, side](std::uint32_t a, std::uint32_t b) {
    const Aabb &box_a = tiles_.receivedTileBox(a), &box_b = tiles_.receivedTileBox(b);
    const float at_a = box_a.min[side] / 2 + box_a.max[side] / 2;
    const float at_b = box_b.min[side] / 2 + box_b.max[side] / 2;
    return at_a != at_b ? at_a < at_b : a < b;
  });
  nodes_.resize(nodes_.size() + 2);
  split(child, first, middle);
  split(child + 1, middle, last);
}

}  // namespace deformable_contact_monitor
