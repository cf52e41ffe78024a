// Compares a box of one body with the eight boxes of a node of another body's tree at once.
#pragma once

#include "core/rules/moved_boxes.h"
#include "core/states/box_tree.h"

namespace deformable_contact_monitor {

// The axes of the body that has the single box, and of the body that has the node.
struct LaneAxes {
  const FrameAxes &of_single, &of_node;
};

// Returns the bits of the lanes whose boxes are not certainly more than `growth` apart along some
// axis, in units of the axes: those of bodies with poses that are no rotations are not 1 long.
// Fills in the largest gaps of all lanes; they are negative where boxes overlap.
std::uint32_t lanesWithin(const LaneAxes& axes, const CentredBox& single, const BoxNode& node,
                          float growth, float* gaps);

// A triangle of one body along the axes of another one: y = U^T (p - t), see rules/moved_boxes.h.
// Points of the other body have such places too, up to the slack of the axes.
struct TriangleInFrame {
  float centre[3], half[3];    // of its box, with the slack and the growth
  float normal[3], low, high;  // all places along some direction, with the same
};

// The same of the eight triangles of a leaf.
struct TrianglesInFrame {
  float centre[3][BoxNode::kLanes], half[3][BoxNode::kLanes], normal[3][BoxNode::kLanes];
  float low[BoxNode::kLanes], high[BoxNode::kLanes];

  TriangleInFrame at(int lane) const {
    return {{centre[0][lane], centre[1][lane], centre[2][lane]},
            {half[0][lane], half[1][lane], half[2][lane]},
            {normal[0][lane], normal[1][lane], normal[2][lane]},
            low[lane],
            high[lane]};
  }
};

// Places the triangles of a leaf, and returns the bits of those that are not certainly more than
// `growth` apart from a box of the other body, whose axes these are. Fills in the largest gaps
// between its box and theirs.
std::uint32_t placeTriangles(const FrameAxes& axes, const LeafCorners& corners, float growth,
                             const CentredBox& box, TrianglesInFrame& placed, float* gaps);

// Returns the bits of the lanes whose boxes may be within the growth.
std::uint32_t lanesWithin(const TriangleInFrame& triangle, const BoxNode& node);

// Computes a lower bound of the squared distance of the boxes, for each lane [m^2].
void squaredGapsOfLanes(const LaneAxes& axes, const CentredBox& single, const BoxNode& node,
                        float* squared);

}  // namespace deformable_contact_monitor
