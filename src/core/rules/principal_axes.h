// The principal axes of a cluster. The sweep runs along the first one: most pairs are apart along
// the axis on which the points spread most.
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Three axes, by falling variance. Any finite, non-zero axes are correct; good ones are fast.
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

// Mean and covariance of the points, relative to the point that their moments are about; zeros
// without a point.
struct Covariance {
  double mean[3], product[3][3];
};

DCM_HD inline Covariance covarianceOf(const Moments& m) {
  const double inverse = m.count > 0 ? 1 / m.count : 0;
  Covariance c{};
  constexpr int kIndex[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  for (int i = 0; i < 3; ++i) c.mean[i] = m.sum[i] * inverse;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      c.product[i][j] = m.product[kIndex[i][j]] * inverse - c.mean[i] * c.mean[j];
    }
  }
  return c;
}

namespace detail {

// Computes eigenvalues by cyclic Jacobi rotations (Golub and Van Loan, "Matrix Computations"). They
// are accurate for every spectrum, also for isotropic, planar and zero ones, where closed forms are
// not. `a` gets the eigenvalues on its diagonal; the columns of `v` become the eigenvectors.
DCM_HD inline void diagonalise(double a[3][3], double v[3][3]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) v[i][j] = i == j ? 1 : 0;
  }
  constexpr int kSweeps = 6;
  for (int rotation = 0; rotation < 3 * kSweeps; ++rotation) {
    const int p = rotation % 3 == 2 ? 1 : 0, q = rotation % 3 == 0 ? 1 : 2;
    // The element is zero for all that float32 axes can resolve.
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
}

}  // namespace detail

DCM_HD inline PrincipalAxes principalAxes(const Covariance& covariance) {
  double a[3][3], v[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) a[i][j] = covariance.product[i][j];
  }
  detail::diagonalise(a, v);
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

}  // namespace deformable_contact_monitor
