// Bounds of the distance of two bodies' parts, from boxes that stay in the bodies' own frames while
// the bodies move. So a pose costs a few products for each pair of bodies, and none for its boxes.
//
// Let body a have the pose p -> R_a p + t_a, and U = R_a. Along column k of U, a point w of a lies
// at U_k . U w = w_k + (E_a w)_k, E_a = U^T U - 1, and a point v of b at M_k . v + offset_k, M =
// U^T R_b, offset = U^T (t_b - t_a). These give the gap g_k of two boxes along that column. The
// vector d between the two nearest points has |U^T d|^2 <= (1 + 3 max|E_a|) |d|^2, because that is
// at least the largest eigenvalue of U U^T. So |d|^2 >= sum of g_k^2 / (1 + 3 max|E_a|). This holds
// for every matrix: one that is no rotation only makes the bound small. The same is done along b's
// axes.
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/predicates/aabb.h"
#include "core/rigid_transform.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// A closed box in its body's own frame [m].
struct CentredBox {
  float centre[3], half[3];

  // The box of points must not be empty, and must be finite.
  DCM_HD static CentredBox of(const Aabb& box) {
    CentredBox centred;
    for (int k = 0; k < 3; ++k) {
      const float low = box.min[k], high = box.max[k];
      const float centre = low / 2 + high / 2;
      centred.centre[k] = centre;
      // Rounded to nearest, a difference is at most half a step too small.
      centred.half[k] = nextafterf(most(high - centre, centre - low), INFINITY);
    }
    return centred;
  }

  DCM_HD float longestHalf() const { return most(most(half[0], half[1]), half[2]); }
  // Returns how far from its body's origin the box reaches along an axis.
  DCM_HD double reach(int k) const { return fabs(static_cast<double>(centre[k])) + half[k]; }
};

namespace detail {

// Posed vertices are rounded to float32, by at most 2^-24 of their size or half of the least
// float32; they are computed in double, with an error of some 2^-50 of their size.
constexpr double kVertexRounding = 0x1p-24 * (1 + 1e-6), kVertexStep = 0x1p-149;

// The rounding of the sums of a gap, as a part of all terms: fewer than 16 operations, each within
// 2^-24.
constexpr double kSumRounding = 0x1p-19;

// Terms up to this neither overflow nor have squares that do.
constexpr double kLargestTerms = 1e18;

}  // namespace detail

// How boxes of two bodies are compared along the axes of one of them.
struct FrameAxes {
  float turn[9];       // M, row by row
  float turn_size[9];  // |M|
  float offset[3];
  float slack[3];  // of all roundings, and of axes that are not orthogonal [m]
  double scale2;   // 1 / (1 + 3 max|E|), rounded down

  // `own` and `other` are poses of the body whose axes are taken, and of the other one. The boxes
  // hold all boxes of the two that will be compared.
  DCM_HD static FrameAxes of(const RigidTransform& own, const CentredBox& own_box,
                             const RigidTransform& other, const CentredBox& other_box) {
    FrameAxes axes;
    double skew = 0, own_sum = 0, rounding[3];
    for (int i = 0; i < 3; ++i) {
      own_sum += own_box.reach(i);
      double size = 2 * detail::kVertexStep;
      size += (fabs(own.translation[i]) + fabs(other.translation[i])) * detail::kVertexRounding;
      for (int j = 0; j < 3; ++j) {
        size += fabs(own.rotation[3 * i + j]) * own_box.reach(j) * detail::kVertexRounding;
        size += fabs(other.rotation[3 * i + j]) * other_box.reach(j) * detail::kVertexRounding;
      }
      rounding[i] = size;
    }
    double terms[3];
    for (int k = 0; k < 3; ++k) {
      double offset = 0, slack = 0;
      terms[k] = own_box.reach(k);
      for (int i = 0; i < 3; ++i) {
        const double r = own.rotation[3 * i + k];
        offset += r * (other.translation[i] - own.translation[i]);
        terms[k] += fabs(r) * (fabs(other.translation[i]) + fabs(own.translation[i]));
        slack += fabs(r) * rounding[i];
      }
      for (int j = 0; j < 3; ++j) {
        double turn = 0, turn_terms = 0, dot = k == j ? -1 : 0;
        for (int i = 0; i < 3; ++i) {
          const double r = own.rotation[3 * i + k];
          turn += r * other.rotation[3 * i + j];
          turn_terms += fabs(r * other.rotation[3 * i + j]);
          dot += r * own.rotation[3 * i + j];
        }
        skew = most(skew, fabs(dot) + 1e-15);
        axes.turn[3 * k + j] = static_cast<float>(turn);
        axes.turn_size[3 * k + j] = static_cast<float>(fabs(turn));
        terms[k] += turn_terms * other_box.reach(j);
      }
      axes.offset[k] = static_cast<float>(offset);
      const bool overflows = !(terms[k] < detail::kLargestTerms);
      terms[k] = overflows ? INFINITY : slack + detail::kSumRounding * terms[k];
    }
    for (int k = 0; k < 3; ++k) {
      axes.slack[k] = static_cast<float>((terms[k] + skew * own_sum) * (1 + 1e-6));
    }
    axes.scale2 = (1 - 1e-12) / (1 + 3 * skew);
    return axes;
  }

  // Returns a lower bound of the squared distance of all points of two boxes [m^2]; 0 if they may
  // overlap. Numbers that overflow leave it 0.
  DCM_HD double squaredGap(const CentredBox& own, const CentredBox& other) const {
    const float x = other.centre[0], y = other.centre[1], z = other.centre[2];
    const float u = other.half[0], v = other.half[1], w = other.half[2];
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const float* const m = turn + 3 * k;
      const float* const s = turn_size + 3 * k;
      const float at = m[0] * x + m[1] * y + m[2] * z + (offset[k] - own.centre[k]);
      const float reach = own.half[k] + (s[0] * u + s[1] * v + s[2] * w) + slack[k];
      const double gap = (at < 0 ? -at : at) - reach;
      if (gap > 0) sum += gap * gap;
    }
    const double squared = sum * scale2;
    return squared > 0 ? squared : 0;
  }
};

// Two bodies, and the axes of either.
struct FramePair {
  FrameAxes of_a, of_b;

  DCM_HD static FramePair of(const RigidTransform& pose_a, const CentredBox& box_a,
                             const RigidTransform& pose_b, const CentredBox& box_b) {
    return {FrameAxes::of(pose_a, box_a, pose_b, box_b),
            FrameAxes::of(pose_b, box_b, pose_a, box_a)};
  }

  // Returns a lower bound of the squared distance of the posed float32 vertices in a box of a from
  // those in a box of b, and of all points between them [m^2]. It stops at the first axes that give
  // more than `enough`.
  DCM_HD double squaredGap(const CentredBox& a, const CentredBox& b, double enough) const {
    const double along_a = of_a.squaredGap(a, b);
    return along_a > enough ? along_a : most(along_a, of_b.squaredGap(b, a));
  }
};

}  // namespace deformable_contact_monitor
