#include "core/states/lane_boxes.h"

#include <cmath>
#include <cstring>

#include "core/common/lanes.h"

// Its functions are compiled for AVX2 too, where eight lanes are one register.
namespace deformable_contact_monitor {
namespace {

using EightLanes = float __attribute__((vector_size(4 * BoxNode::kLanes)));
static_assert(BoxNode::kLanes == 8);
using EightInts = int __attribute__((vector_size(4 * BoxNode::kLanes)));

[[gnu::always_inline]] inline void load(const float* from, EightLanes& lanes) {
  std::memcpy(&lanes, from, sizeof lanes);
}

// Computes the gaps along axis k of the single box's body.
[[gnu::always_inline]] inline void gapsAlongSingle(const FrameAxes& axes, int k,
                                                   const CentredBox& single,
                                                   const EightLanes* centre, const EightLanes* half,
                                                   EightLanes& gap) {
  const float* const m = axes.turn + 3 * k;
  const float* const s = axes.turn_size + 3 * k;
  const EightLanes at =
      m[0] * centre[0] + m[1] * centre[1] + m[2] * centre[2] + (axes.offset[k] - single.centre[k]);
  const EightLanes reach =
      s[0] * half[0] + s[1] * half[1] + s[2] * half[2] + (single.half[k] + axes.slack[k]);
  gap = (at < 0 ? -at : at) - reach;
}

// Computes the gaps along axis k of the node's body.
[[gnu::always_inline]] inline void gapsAlongNode(const FrameAxes& axes, int k,
                                                 const CentredBox& single, const EightLanes* centre,
                                                 const EightLanes* half, EightLanes& gap) {
  const float* const m = axes.turn + 3 * k;
  const float* const s = axes.turn_size + 3 * k;
  const float of_single =
      m[0] * single.centre[0] + m[1] * single.centre[1] + m[2] * single.centre[2] + axes.offset[k];
  const float reach =
      s[0] * single.half[0] + s[1] * single.half[1] + s[2] * single.half[2] + axes.slack[k];
  const EightLanes at = of_single - centre[k];
  gap = (at < 0 ? -at : at) - (half[k] + reach);
}

// Computes normals of triangles, and their sizes in the sum of coordinates.
[[gnu::always_inline]] inline void findNormals(const EightLanes (&corner)[3][3],
                                               EightLanes (&normal)[3], EightLanes& size) {
  EightLanes p[3], q[3];
  for (int k = 0; k < 3; ++k) {
    p[k] = corner[1][k] - corner[0][k];
    q[k] = corner[2][k] - corner[0][k];
  }
  size = EightLanes{};
  for (int k = 0; k < 3; ++k) {
    const int i = k == 2 ? 0 : k + 1, j = k == 0 ? 2 : k - 1;
    normal[k] = p[i] * q[j] - p[j] * q[i];
    size += normal[k] < 0 ? -normal[k] : normal[k];
  }
}

// Returns the bits of the lanes for which a comparison does not hold.
[[gnu::always_inline]] inline std::uint32_t otherLanes(const EightInts& holds) {
  IntLanes halves[2];
  std::memcpy(halves, &holds, sizeof holds);
  return ~static_cast<std::uint32_t>(laneBits(halves[0]) | laneBits(halves[1]) << 4) & 0xff;
}

}  // namespace

// The errors are some 2^-24 of the terms, and the slack is 2^-19 of them, so twice the slack is
// enough for all of them. Any normal is right, as far as it is used for all places alike.
DCM_WIDE_CLONES std::uint32_t placeTriangles(const FrameAxes& axes, const LeafCorners& corners,
                                             float growth, const CentredBox& box,
                                             TrianglesInFrame& placed, float* gaps) {
  const EightLanes none{};
  EightLanes y[3][3];
  for (int c = 0; c < 3; ++c) {
    EightLanes v[3];
    for (int k = 0; k < 3; ++k) load(corners.at[c][k], v[k]);
    for (int k = 0; k < 3; ++k) {
      const float* const m = axes.turn + 3 * k;
      y[c][k] = m[0] * v[0] + m[1] * v[1] + m[2] * v[2] + axes.offset[k];
    }
  }
  EightLanes normal[3], size;
  findNormals(y, normal, size);
  const EightInts is_usual =
      (size > 1e-20F) & (size < 1e18F);  // products neither vanish nor overflow
  const float grown = growth * (1 + 1e-6F);
  EightLanes reach = is_usual ? grown * size : none, gap = none - INFINITY;
  EightLanes low{}, high{}, at{}, of_box{};
  for (int k = 0; k < 3; ++k) {
    const EightLanes low_k = y[0][k] < y[1][k] ? y[0][k] : y[1][k];
    const EightLanes high_k = y[0][k] > y[1][k] ? y[0][k] : y[1][k];
    const EightLanes least_k = low_k < y[2][k] ? low_k : y[2][k];
    const EightLanes most_k = high_k > y[2][k] ? high_k : y[2][k];
    const float slack = 2 * axes.slack[k];
    const EightLanes centre = (least_k + most_k) * 0.5F;
    const EightLanes half = (most_k - least_k) * 0.5F + (slack + grown);
    const EightLanes off = centre - box.centre[k];
    const EightLanes more = (off < 0 ? -off : off) - (half + box.half[k]);
    gap = more > gap ? more : gap;
    normal[k] = is_usual ? normal[k] : none;
    const EightLanes normal_size = normal[k] < 0 ? -normal[k] : normal[k];
    reach += normal_size * slack;
    at += normal[k] * box.centre[k];
    of_box += normal_size * box.half[k];
    std::memcpy(placed.centre[k], &centre, sizeof centre);
    std::memcpy(placed.half[k], &half, sizeof half);
    std::memcpy(placed.normal[k], &normal[k], sizeof normal[k]);
  }
  for (int c = 0; c < 3; ++c) {
    const EightLanes place = normal[0] * y[c][0] + normal[1] * y[c][1] + normal[2] * y[c][2];
    low = c == 0 ? place : (place < low ? place : low);
    high = c == 0 ? place : (place > high ? place : high);
  }
  low -= reach;
  high += reach;
  std::memcpy(placed.low, &low, sizeof low);
  std::memcpy(placed.high, &high, sizeof high);
  std::memcpy(gaps, &gap, sizeof gap);
  const EightLanes above = at - of_box - high, below = low - at - of_box;
  return otherLanes((gap > 0) | (above > 0) | (below > 0));
}

DCM_WIDE_CLONES std::uint32_t lanesWithin(const TriangleInFrame& triangle, const BoxNode& node) {
  EightLanes along{}, reach{}, gap{};
  for (int k = 0; k < 3; ++k) {
    EightLanes centre, half;
    load(node.centre[k], centre);
    load(node.half[k], half);
    const EightLanes off = centre - triangle.centre[k];
    const EightLanes more = (off < 0 ? -off : off) - (half + triangle.half[k]);
    gap = more > gap ? more : gap;
    along += triangle.normal[k] * centre;
    reach += std::fabs(triangle.normal[k]) * half;
  }
  const EightLanes above = along - reach - triangle.high, below = triangle.low - along - reach;
  gap = above > gap ? above : gap;
  gap = below > gap ? below : gap;
  return otherLanes(gap > 0);
}

DCM_WIDE_CLONES std::uint32_t lanesWithin(const LaneAxes& axes, const CentredBox& single,
                                          const BoxNode& node, float growth, float* gaps) {
  EightLanes centre[3], half[3], gap, more;
  for (int k = 0; k < 3; ++k) {
    load(node.centre[k], centre[k]);
    load(node.half[k], half[k]);
  }
  gapsAlongNode(axes.of_node, 0, single, centre, half, gap);
  for (int k = 1; k < 3; ++k) {
    gapsAlongNode(axes.of_node, k, single, centre, half, more);
    gap = more > gap ? more : gap;
  }
  for (int k = 0; k < 3; ++k) {
    gapsAlongSingle(axes.of_single, k, single, centre, half, more);
    gap = more > gap ? more : gap;
  }
  std::memcpy(gaps, &gap, sizeof gap);
  return otherLanes(gap > growth);
}

DCM_WIDE_CLONES void squaredGapsOfLanes(const LaneAxes& axes, const CentredBox& single,
                                        const BoxNode& node, float* squared) {
  constexpr float kRounding = 1 - 1e-6F;
  const float scale_node = static_cast<float>(axes.of_node.scale2) * kRounding;
  const float scale_single = static_cast<float>(axes.of_single.scale2) * kRounding;
  EightLanes centre[3], half[3], gap, along_node{}, along_single{};
  const EightLanes none{};
  for (int k = 0; k < 3; ++k) {
    load(node.centre[k], centre[k]);
    load(node.half[k], half[k]);
  }
  for (int k = 0; k < 3; ++k) {
    gapsAlongNode(axes.of_node, k, single, centre, half, gap);
    along_node += gap > 0 ? gap * gap : none;
    gapsAlongSingle(axes.of_single, k, single, centre, half, gap);
    along_single += gap > 0 ? gap * gap : none;
  }
  along_node *= scale_node;
  along_single *= scale_single;
  EightLanes larger = along_single > along_node ? along_single : along_node;
  larger = larger > 0 ? larger : none;  // not NaN
  std::memcpy(squared, &larger, sizeof larger);
}

}  // namespace deformable_contact_monitor
