// Principal axes of a cluster, and conservative intervals along them.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/predicates/host_device.h"
#include "core/predicates/vector3.h"
#include "core/rules/scene_scale.h"

namespace deformable_contact_monitor {

// Three axes by falling variance. Any finite, non-zero axes are safe; good ones are fast.
struct PrincipalAxes {
  Vec3f axis[3];
};

// Second moments about a point near the cluster, so that nothing cancels far from the origin.
struct Moments {
  double sum[3] = {0, 0, 0};
  double product[6] = {0, 0, 0, 0, 0, 0};  // xx xy xz yy yz zz
  double count = 0;

  DCM_HD void add(const Vec3f& d) {
    const double x = d.x, y = d.y, z = d.z;
    sum[0] += x;
    sum[1] += y;
    sum[2] += z;
    product[0] += x * x;
    product[1] += x * y;
    product[2] += x * z;
    product[3] += y * y;
    product[4] += y * z;
    product[5] += z * z;
    count += 1;
  }
};

// Cyclic Jacobi rotations: accurate for every spectrum, also isotropic, planar and zero ones, where
// closed forms are not.
DCM_HD inline PrincipalAxes principalAxes(const Moments& m) {
  const double inverse = m.count > 0 ? 1 / m.count : 0;
  const double mean[3] = {m.sum[0] * inverse, m.sum[1] * inverse, m.sum[2] * inverse};
  double a[3][3];
  constexpr int kIndex[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      a[i][j] = m.product[kIndex[i][j]] * inverse - mean[i] * mean[j];
    }
  }
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // columns
  constexpr int kSweeps = 6;
  for (int rotation = 0; rotation < 3 * kSweeps; ++rotation) {
    const int p = rotation % 3 == 2 ? 1 : 0, q = rotation % 3 == 0 ? 1 : 2;
    // Nothing left to turn, for all that float32 axes can tell.
    if (fabs(a[p][q]) <= 1e-12 * (fabs(a[p][p]) + fabs(a[q][q])) + 1e-300) continue;
    const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    const double t = (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(theta * theta + 1));
    const double c = 1 / sqrt(t * t + 1), s = t * c;
    for (int k = 0; k < 3; ++k) {
      const double x = a[k][p], y = a[k][q];
      a[k][p] = c * x - s * y;
      a[k][q] = s * x + c * y;
    }
    for (int k = 0; k < 3; ++k) {
      const double x = a[p][k], y = a[q][k];
      a[p][k] = c * x - s * y;
      a[q][k] = s * x + c * y;
      const double vx = v[k][p], vy = v[k][q];
      v[k][p] = c * vx - s * vy;
      v[k][q] = s * vx + c * vy;
    }
  }
  int order[3] = {0, 1, 2};
  const auto swapIfLess = [&](int i, int j) {
    if (a[order[i]][order[i]] < a[order[j]][order[j]]) {
      const int kept = order[i];
      order[i] = order[j];
      order[j] = kept;
    }
  };
  swapIfLess(0, 1);
  swapIfLess(1, 2);
  swapIfLess(0, 1);
  PrincipalAxes axes;
  for (int i = 0; i < 3; ++i) {
    const double x = v[0][order[i]], y = v[1][order[i]], z = v[2][order[i]];
    const double length2 = x * x + y * y + z * z;
    const bool usable = length2 > 0.25 && length2 < 4;  // false for NaN
    axes.axis[i] = usable
                       ? Vec3f{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)}
                       : Vec3f{i == 0 ? 1.0F : 0.0F, i == 1 ? 1.0F : 0.0F, i == 2 ? 1.0F : 0.0F};
  }
  return axes;
}

struct Interval {
  float lo, hi;
};

// The interval of a scaled triangle along a stored axis, grown by the margin and by all that
// rounding can have moved: the exact projections of the unrounded triangle lie inside.
DCM_HD inline Interval project(const Vec3f& axis, const Vec3f v[3], float margin) {
  const float p0 = dot(axis, v[0]), p1 = dot(axis, v[1]), p2 = dot(axis, v[2]);
  const float mx = most(fabsf(v[0].x), most(fabsf(v[1].x), fabsf(v[2].x)));
  const float my = most(fabsf(v[0].y), most(fabsf(v[1].y), fabsf(v[2].y)));
  const float mz = most(fabsf(v[0].z), most(fabsf(v[1].z), fabsf(v[2].z)));
  // u = 2^-24: 1 for the scaled coordinate, 3 for the dot product, 1 for the sum below, slack.
  constexpr float kError = 6 * kScaledError;
  const float pad =
      (fabsf(axis.x) * mx + fabsf(axis.y) * my + fabsf(axis.z) * mz) * kError + margin + 1e-44F;
  return {least(p0, least(p1, p2)) - pad, most(p0, most(p1, p2)) + pad};
}

// Two intervals on 15 bits each, in the two halves of a word; the top bit of each half is spare. A
// monotone map keeps lo <= hi, so nothing that overlaps is lost.
struct PackedBox {
  std::uint32_t lo, hi;
};

constexpr std::uint32_t kPackedGuard = 0x80008000U;

struct Quantiser {
  float origin = 0, scale = 0;

  Quantiser() = default;
  DCM_HD Quantiser(float lo, float hi) : origin(lo), scale(32767.0F / (hi - lo)) {
    if (!(scale < 1e37F)) scale = 0;
  }
  DCM_HD std::uint32_t operator()(float x) const {
    return static_cast<std::uint32_t>(least(most((x - origin) * scale, 0.0F), 32767.0F));
  }
};

DCM_HD inline PackedBox pack(const Quantiser q[2], const Interval i[2]) {
  return {q[0](i[0].lo) | q[1](i[1].lo) << 16, q[0](i[0].hi) | q[1](i[1].hi) << 16};
}

// Closed overlap on both axes: no half borrows from its guard bit.
DCM_HD inline bool overlap(const PackedBox& a, const PackedBox& b) {
  return (((a.hi | kPackedGuard) - b.lo) & ((b.hi | kPackedGuard) - a.lo) & kPackedGuard) ==
         kPackedGuard;
}

}  // namespace deformable_contact_monitor
