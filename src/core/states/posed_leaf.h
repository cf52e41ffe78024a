// The triangles of a leaf in the scene frame, and which of two leaves' triangles may be near.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/posed_body.h"
#include "core/predicates/triangle.h"
#include "core/states/box_tree.h"

namespace deformable_contact_monitor {

// Holds those triangles whose posed vertices are finite.
struct PosedLeaf {
  std::size_t count = 0;
  std::uint32_t index[BoxNode::kLanes];
  Triangle triangle[BoxNode::kLanes];
  // Bounds by axis. Entries beyond `count` repeat the last triangle's.
  float low[3][BoxNode::kLanes], high[3][BoxNode::kLanes];

  // Takes the triangles of these lanes, given by their bits.
  void make(const BoxNode& leaf, std::uint32_t lanes, const PosedBody& body);
};

// A pair of triangles of two leaves.
struct NearLanes {
  double low_m;  // they are certainly no nearer than this [m]
  std::uint8_t a, b;
  bool boxes_meet;  // otherwise they do not intersect
};

// Fills `near` with the pairs that are not certainly at least needed_m > 0 apart, the nearest
// first. `direction` is from a to b; if it is not zero, bounds along it are used, too.
void nearLanes(const PosedLeaf& a, const PosedLeaf& b, const Vec3d& direction, double needed_m,
               std::vector<NearLanes>& near);

}  // namespace deformable_contact_monitor
