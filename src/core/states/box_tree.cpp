// Triangles are ordered by halving them again and again along the longest side. Each node has eight
// parts of equal size, so that all nodes but the last of each level are full. When the mesh
// deforms, the order stays, and boxes grow with distances of triangles that were neighbours. Once
// the leaves' boxes are much larger than they were, the triangles are ordered anew.
#include "core/states/box_tree.h"

#include <algorithm>

#include "core/common/posed_body.h"
#include "core/predicates/aabb.h"

namespace deformable_contact_monitor {
bool BoxTree::update(const Body& body, const CycleLimit& limit) {
  constexpr double kMuchLarger = 1.5;
  if (vertices_revision_ == body.vertices_revision && parts_revision_ == body.parts_revision) {
    return true;
  }
  vertices_revision_ = 0;
  const bool is_new = topology_revision_ != body.topology_revision;
  if (is_new) order(body, limit);
  if (limit.over()) return false;
  fit(body);
  if (!is_new && size_ > kMuchLarger * ordered_size_) {
    order(body, limit);
    if (limit.over()) return false;
    fit(body);
    ordered_size_ = size_;
  }
  if (is_new) ordered_size_ = size_;
  vertices_revision_ = body.vertices_revision;
  parts_revision_ = body.parts_revision;
  return true;
}

// Makes the nodes, without their boxes. They are of no use if the limit is over.
void BoxTree::order(const Body& body, const CycleLimit& limit) {
  topology_revision_ = 0;
  nodes_.clear();
  corners_.clear();
  std::vector<PlacedTriangle> triangles(body.mesh.triangleCount());
  const PosedBody of(body);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Triangle triangle = of.received(t);
    triangles[t] = {{0, 0, 0}, t};
    if (!isFinite(triangle)) continue;
    const CentredBox box = CentredBox::of(boxOf(triangle));
    triangles[t].at = {box.centre[0], box.centre[1], box.centre[2]};
  }
  if (!triangles.empty()) split(triangles.data(), triangles.data() + triangles.size(), limit);
  if (!limit.over()) topology_revision_ = body.topology_revision;
}

// Adds a node of these triangles, and all below it. Returns its number.
std::uint32_t BoxTree::split(PlacedTriangle* first, PlacedTriangle* last, const CycleLimit& limit) {
  const auto count = static_cast<std::size_t>(last - first);
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_[number].is_leaf = count <= BoxNode::kLanes;
  if (nodes_[number].is_leaf) {
    nodes_[number].count = static_cast<std::uint32_t>(count);
    nodes_[number].leaf = static_cast<std::uint32_t>(corners_.size());
    corners_.emplace_back();
    for (std::size_t i = 0; i < count; ++i) nodes_[number].child[i] = first[i].triangle;
    return number;
  }
  std::size_t unit = BoxNode::kLanes;  // triangles of a full child
  while (unit * BoxNode::kLanes < count) unit *= BoxNode::kLanes;
  nodes_[number].count = static_cast<std::uint32_t>((count + unit - 1) / unit);
  halve(limit, first, last, unit);
  for (std::size_t i = 0; i < nodes_[number].count && !limit.over(); ++i) {
    const std::uint32_t child =
        split(first + i * unit, std::min(last, first + (i + 1) * unit), limit);
    nodes_[number].child[i] = child;
  }
  return number;
}

// Makes the boxes of all nodes, children first.
void BoxTree::fit(const Body& body) {
  boxes_.resize(nodes_.size());
  size_ = 0;
  for (std::size_t i = nodes_.size(); i > 0; --i) {
    BoxNode& node = nodes_[i - 1];
    fitNode(body, node, boxes_[i - 1]);
    if (node.is_leaf) {
      size_ += double{node.box.half[0]} + node.box.half[1] + node.box.half[2];
    }
  }
  box_ = boxes_.empty() ? Aabb() : boxes_[0];
}

void BoxTree::fitNode(const Body& body, BoxNode& node, Aabb& box) {
  box = Aabb();
  node.used = 0;
  const PosedBody of(body);
  std::uint16_t parts[BoxNode::kLanes];
  for (std::size_t i = 0; i < BoxNode::kLanes; ++i) {
    Aabb of_lane;
    node.first[i] = ~std::uint32_t{0};
    if (i < node.count && node.is_leaf) {
      const Triangle triangle = of.received(node.child[i]);
      if (isFinite(triangle)) {
        of_lane = boxOf(triangle);
        for (int c = 0; c < 3; ++c) {
          for (int k = 0; k < 3; ++k) corners_[node.leaf].at[c][k][i] = triangle.v[c][k];
        }
      }
      node.first[i] = node.child[i];
      parts[i] = body.partOf(node.child[i]);
    } else if (i < node.count) {
      const BoxNode& child = nodes_[node.child[i]];
      of_lane = boxes_[node.child[i]];
      node.first[i] = *std::min_element(child.first, child.first + child.count);
      parts[i] = child.part;
    }
    CentredBox centred{{0, 0, 0}, {0, 0, 0}};
    if (!of_lane.empty()) {
      centred = CentredBox::of(of_lane);
      box.include(of_lane);
      node.used |= std::uint32_t{1} << i;
    }
    for (int k = 0; k < 3; ++k) {
      node.centre[k][i] = centred.centre[k];
      node.half[k][i] = centred.half[k];
    }
  }
  const bool same = std::all_of(parts, parts + node.count,
                                [&parts](std::uint16_t part) { return part == parts[0]; });
  node.part = same ? parts[0] : BoxNode::kSeveralParts;
  node.box = box.empty() ? CentredBox{{0, 0, 0}, {0, 0, 0}} : CentredBox::of(box);
}

}  // namespace deformable_contact_monitor
