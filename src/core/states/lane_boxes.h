// Compares a box of one body with the eight boxes of a node of another body's tree at once.
#pragma once

#include "core/rules/moved_boxes.h"
#include "core/states/box_tree.h"

namespace deformable_contact_monitor {

// The axes of the body that has the single box, and of the body that has the node.
struct LaneAxes {
  const FrameAxes<float>&of_single, &of_node;
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
  float normal_size[3];

  // `axes` are those of the other body, and `triangle` is in its own body's frame. Boxes of the
  // other body that are more than `growth` apart from it shall not count.
  TriangleInFrame(const FrameAxes<float>& axes, const Triangle& triangle, float growth);
};

// Returns the bits of the lanes whose boxes may be within the growth.
std::uint32_t lanesWithin(const TriangleInFrame& triangle, const BoxNode& node);

// Computes a lower bound of the squared distance of the boxes, for each lane [m^2].
void squaredGapsOfLanes(const LaneAxes& axes, const CentredBox& single, const BoxNode& node,
                        float* squared);

}  // namespace deformable_contact_monitor
