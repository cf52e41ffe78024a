#include "core/states/posed_leaf.h"

#include <algorithm>
#include <cmath>

#include "core/common/lanes.h"
#include "core/predicates/aabb.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kLanes = BoxNode::kLanes;

// Differences of float32 numbers in double, their squares and sums have a relative error of a few
// 2^-53.
constexpr double kGapRounding = 1 - 1e-14;

// Computes the squared gaps between the box of a triangle of `a` and the boxes of `b` [m^2].
DCM_WIDE_CLONES void squaredGapsOf(const PosedLeaf& a, std::size_t s, const PosedLeaf& b,
                                   double* squared) {
  for (std::size_t t = 0; t < kLanes; ++t) squared[t] = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double low = a.low[k][s], high = a.high[k][s];
    for (std::size_t t = 0; t < kLanes; ++t) {
      const double above = b.low[k][t] - high, below = low - b.high[k][t];
      const double gap = most(most(above, below), 0.0);
      squared[t] += gap * gap;
    }
  }
}

// The places of triangles along a direction, relative to a point.
struct Ends {
  double low[kLanes], high[kLanes];

  Ends(const PosedLeaf& leaf, const Vec3d& direction, const Vec3d& from) {
    for (std::size_t t = 0; t < leaf.count; ++t) {
      const auto at = [&](int k) { return dot(direction, toDouble(leaf.triangle[t].v[k]) - from); };
      const double p = at(0), q = at(1), r = at(2);
      low[t] = least(least(p, q), r);
      high[t] = most(most(p, q), r);
    }
  }
};

// Returns a number that is at least the sum of the coordinates of each vertex.
double sizeOf(const PosedLeaf& leaf) {
  double size = 0;
  for (int k = 0; k < 3; ++k) {
    for (std::size_t t = 0; t < leaf.count; ++t) {
      size =
          most(size, most(std::fabs(double{leaf.low[k][t]}), std::fabs(double{leaf.high[k][t]})));
    }
  }
  return 3 * size;
}

}  // namespace

void PosedLeaf::make(const BoxNode& leaf, std::uint32_t lanes, const PosedBody& body) {
  count = 0;
  for (; lanes != 0; lanes &= lanes - 1) {
    const std::uint32_t child = leaf.child[__builtin_ctz(lanes)];
    const Triangle posed = body.triangle(child);
    if (!isFinite(posed)) continue;
    index[count] = child;
    triangle[count++] = posed;
  }
  for (std::size_t i = 0; i < kLanes && count > 0; ++i) {
    const Aabb box = boxOf(triangle[std::min(i, count - 1)]);
    for (int k = 0; k < 3; ++k) {
      low[k][i] = box.min[k];
      high[k][i] = box.max[k];
    }
  }
}

void nearLanes(const PosedLeaf& a, const PosedLeaf& b, const Vec3d& direction, double needed_m,
               std::vector<NearLanes>& near) {
  near.clear();
  if (a.count == 0 || b.count == 0) return;
  const bool has_direction = direction != Vec3d();
  const Vec3d from = toDouble(a.triangle[0].v[0]);
  const Ends ends_a(a, direction, from), ends_b(b, direction, from);
  const double scale = has_direction ? (1 - 1e-12) / std::sqrt(dot(direction, direction)) : 0;
  const double slack_m = has_direction ? 1e-14 * (sizeOf(a) + sizeOf(b)) : 0;
  const double needed2 = needed_m * needed_m * (1 + 1e-12);  // so its root is not less
  for (std::size_t s = 0; s < a.count; ++s) {
    double squared[kLanes];
    squaredGapsOf(a, s, b, squared);
    for (std::size_t t = 0; t < b.count; ++t) {
      const double low2 = squared[t] * (kGapRounding * kGapRounding);
      if (low2 >= needed2) continue;
      const double along_m = (ends_b.low[t] - ends_a.high[s]) * scale - slack_m;
      if (along_m >= needed_m) continue;
      near.push_back({most(std::sqrt(low2), along_m), static_cast<std::uint8_t>(s),
                      static_cast<std::uint8_t>(t), low2 == 0});
    }
  }
  std::sort(near.begin(), near.end(), [](const NearLanes& x, const NearLanes& y) {
    if (x.low_m != y.low_m) return x.low_m < y.low_m;
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
}

}  // namespace deformable_contact_monitor
