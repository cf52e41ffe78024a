// Signs of orientation determinants of float32 points: a floating-point filter first, then exact
// arithmetic.
//
// Filters follow Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates" (1997). For finite float32 input nothing here overflows or underflows in double:
// every term is a multiple of 2^-447 and at most 2^390.
#pragma once

#include <cstdint>

#include "core/host_device.h"
#include "core/pair_settings.h"
#include "core/predicates/exact_integers.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Says how verdicts are reached, and counts what they took. Each thread has its own.
struct PredicateState {
  Predicates mode = Predicates::kExact;
  std::uint32_t exact = 0;  // determinants that reached exact arithmetic
  bool undecided = false;   // conservative: a filter left a sign open since this was last cleared
};

// A sum of doubles, kept exactly: as nonoverlapping components of growing size (Shewchuk's
// expansion). kCapacity is the largest number of components.
template <int kCapacity>
class Expansion {
 public:
  DCM_HD void add(double term) {
    if (term == 0) return;
    int kept = 0;
    double sum = term;
    for (int i = 0; i < size_; ++i) {
      const double s = sum + component_[i];
      const double b = s - sum;
      const double error = (sum - (s - b)) + (component_[i] - b);
      sum = s;
      if (error != 0) component_[kept++] = error;
    }
    if (sum != 0) component_[kept++] = sum;
    size_ = kept;
  }

  // Adds x * y exactly, for factors whose product has an exact remainder in double.
  DCM_HD void addProduct(double x, double y) {
    const double high = x * y;
    add(fma(x, y, -high));
    add(high);
  }

  // Adds a multiple of another sum exactly, within the same bounds.
  template <int N>
  DCM_HD void addMultiple(const Expansion<N>& other, double factor) {
    for (int i = 0; i < other.size(); ++i) addProduct(other.component(i), factor);
  }

  // Makes the components few: each one is at most 2^-52 of the next one. (The first half of
  // Shewchuk's Compress.)
  DCM_HD void compress() {
    if (size_ == 0) return;
    int bottom = size_ - 1;
    double sum = component_[bottom];
    for (int i = size_ - 2; i >= 0; --i) {
      const double s = sum + component_[i];
      const double error = component_[i] - (s - sum);  // exact, for |sum| > |component_[i]|
      if (error != 0) component_[bottom--] = s;
      sum = error != 0 ? error : s;
    }
    component_[bottom] = sum;
    for (int i = bottom; i < size_; ++i) component_[i - bottom] = component_[i];
    size_ -= bottom;
  }

  DCM_HD int size() const { return size_; }
  DCM_HD double component(int i) const { return component_[i]; }

  DCM_HD int sign() const {
    if (size_ == 0) return 0;
    return component_[size_ - 1] > 0 ? 1 : -1;
  }

  // Returns the sum, rounded; it is off by less than 2^-51 of itself.
  DCM_HD double value() const {
    double sum = 0;
    for (int i = 0; i < size_; ++i) sum += component_[i];
    return sum;
  }

 private:
  double component_[kCapacity];
  int size_ = 0;
};

DCM_HD inline int signOf(double value) { return (value > 0) - (value < 0); }

namespace detail {

// Adds sign * x * y * z exactly.
template <int N>
DCM_HD inline void addTriple(Expansion<N>& sum, double x, double y, double z) {
  const double high = x * y;
  const double low = fma(x, y, -high);
  sum.addProduct(high, z);
  if (low != 0) sum.addProduct(low, z);
}

template <int N>
DCM_HD inline void addDeterminant(Expansion<N>& sum, const Vec3d& a, const Vec3d& b, const Vec3d& c,
                                  double sign) {
  addTriple(sum, sign * a.x, b.y, c.z);
  addTriple(sum, -sign * a.x, b.z, c.y);
  addTriple(sum, sign * a.y, b.z, c.x);
  addTriple(sum, -sign * a.y, b.x, c.z);
  addTriple(sum, sign * a.z, b.x, c.y);
  addTriple(sum, -sign * a.z, b.y, c.x);
}

}  // namespace detail

// Adds det[b-a; c-a; d-a] exactly: the four minors of the 4x4 determinant. On the device, a sum
// that a function returns takes room on the stack twice.
DCM_HD inline void addOrient3d(Expansion<48>& sum, const Vec3f& a, const Vec3f& b, const Vec3f& c,
                               const Vec3f& d) {
  detail::addDeterminant(sum, toDouble(b), toDouble(c), toDouble(d), 1);
  detail::addDeterminant(sum, toDouble(a), toDouble(c), toDouble(d), -1);
  detail::addDeterminant(sum, toDouble(a), toDouble(b), toDouble(d), 1);
  detail::addDeterminant(sum, toDouble(a), toDouble(b), toDouble(c), -1);
}

// A filter's answer if it cannot tell the sign.
constexpr int kUncertain = 2;

namespace detail {

// Arithmetic in float or double that notices when a result is not exact.
template <class Real>
struct ErrorFree {
  bool exact = true;  // all results so far

  // Returns x - y. Of the two differences, the one from the greater number is computed without an
  // error (Dekker, "A Floating-Point Technique for Extending the Available Precision", 1971), so
  // that it differs from the other number iff x - y was rounded.
  DCM_HD Real difference(Real x, Real y) {
    const Real z = x - y;
    exact = exact && x - z == y && z + y == x;
    return z;
  }
  DCM_HD Real product(Real x, Real y) {
    const Real z = x * y;
    exact = exact && fma(x, y, -z) == 0;
    return z;
  }
  DCM_HD Vec3<Real> difference(const Vec3f& p, const Vec3f& q) {
    return {difference(p.x, q.x), difference(p.y, q.y), difference(p.z, q.z)};
  }
  // Returns xy - zw.
  DCM_HD Real minor(Real x, Real y, Real z, Real w) {
    return difference(product(x, y), product(z, w));
  }
};

// Returns the sign of x y + z w + s t, or kUncertain. Each product is the sum of its rounded value
// and the error of that, which is a double too.
DCM_HD inline int signOfProducts(double x, double y, double z, double w, double s, double t) {
  const double first = x * y, second = z * w, third = s * t;
  const double sum = first + second, all = sum + third;
  const double second_kept = sum - first, third_kept = all - sum;
  const double errors[5] = {fma(x, y, -first), fma(z, w, -second), fma(s, t, -third),
                            (first - (sum - second_kept)) + (second - second_kept),
                            (sum - (all - third_kept)) + (third - third_kept)};
  ErrorFree<double> check;
  double rest = 0, size = 0;
  for (const double error : errors) {
    rest = check.difference(rest, -error);
    size += fabs(error);
  }
  constexpr double kSlack = 1 + 0x1p-50;  // of the sum of the sizes
  if (fabs(all) > size * kSlack) return signOf(all);
  return all == 0 && check.exact ? signOf(rest) : kUncertain;
}

}  // namespace detail

// The plane through three points. `exact` says whether double holds its normal exactly, as for most
// coordinates of similar size.
struct ErrorFreePlane {
  Vec3f origin;
  Vec3d normal;
  bool exact;

  DCM_HD ErrorFreePlane(const Vec3f& a, const Vec3f& b, const Vec3f& c) : origin(a) {
    detail::ErrorFree<double> check;
    const Vec3d u = check.difference(b, a), v = check.difference(c, a);
    normal = {check.minor(u.y, v.z, u.z, v.y), check.minor(u.z, v.x, u.x, v.z),
              check.minor(u.x, v.y, u.y, v.x)};
    exact = check.exact;
  }

  // Returns the axis along which a triangle of the plane has about the largest projection.
  DCM_HD int broadAxis() const {
    const double x = fabs(normal.x), y = fabs(normal.y), z = fabs(normal.z);
    return x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
  }
  // Returns the exact sign of det[b-a; c-a; d-a], or kUncertain.
  DCM_HD int side(const Vec3f& d) const {
    detail::ErrorFree<double> check{exact};
    const Vec3d w = check.difference(d, origin);
    if (!check.exact) return kUncertain;
    return detail::signOfProducts(normal.x, w.x, normal.y, w.y, normal.z, w.z);
  }
};

// Returns the sign of det[b-a; c-a; d-a] by exact sums alone.
DCM_HD DCM_RARE inline int orient3dExpanded(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                            const Vec3f& d) {
  Expansion<48> sum;
  addOrient3d(sum, a, b, c, d);
  return sum.sign();
}

// Returns the exact sign of det[b-a; c-a; d-a], by integers where they suffice.
DCM_HD DCM_RARE inline int orient3dInIntegers(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                              const Vec3f& d) {
#if DCM_INT128
  const float x[12] = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z};
  std::int64_t i[12];
  if (toIntegers(x, i)) {
    for (int k = 3; k < 12; ++k) i[k] -= i[k % 3];
    return determinantSign(i + 3, i + 6, i + 9);
  }
#endif
  return orient3dExpanded(a, b, c, d);
}

// Returns the exact sign of det[b-a; c-a; d-a], by doubles where they suffice.
DCM_HD DCM_RARE inline int orient3dExact(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                         const Vec3f& d) {
  const int sign = ErrorFreePlane(a, b, c).side(d);
  return sign != kUncertain ? sign : orient3dInIntegers(a, b, c, d);
}

// Returns det[b-a; c-a; d-a] in double, and the sum of the sizes of its terms (the permanent).
DCM_HD inline double orient3dDouble(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d,
                                    double& permanent) {
  const Vec3d o = toDouble(a);
  const Vec3d u = toDouble(b) - o, v = toDouble(c) - o, w = toDouble(d) - o;
  const double m1 = v.y * w.z, m2 = v.z * w.y, m3 = v.z * w.x;
  const double m4 = v.x * w.z, m5 = v.x * w.y, m6 = v.y * w.x;
  permanent = fabs(u.x) * (fabs(m1) + fabs(m2)) + fabs(u.y) * (fabs(m3) + fabs(m4)) +
              fabs(u.z) * (fabs(m5) + fabs(m6));
  return u.x * (m1 - m2) + u.y * (m3 - m4) + u.z * (m5 - m6);
}

// Returns the sign of det[b-a; c-a; d-a] by double arithmetic, or kUncertain.
DCM_HD inline int orient3dFiltered(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  double permanent;
  const double det = orient3dDouble(a, b, c, d, permanent);
  constexpr double kBound = 7.7715611723761e-16;  // (7 + 56 eps) eps, eps = 2^-53
  const double bound = kBound * permanent;
  if (det > bound) return 1;
  if (-det > bound) return -1;
  return permanent == 0 ? 0 : kUncertain;  // no term was rounded to zero: common in flat scenes
}

// Returns whether two of three points are equal, as two of each triangle of a rope. A determinant
// with both is 0, though its rounded terms may not add up to that.
DCM_HD inline bool haveEqual(const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  return b == c || b == d || c == d;
}

// Returns the sign of det[b-a; c-a; d-a], as state.mode asks for. It is positive iff d sees a, b, c
// counterclockwise from above, that is, iff d lies on the side to which (b-a) x (c-a) points.
DCM_HD DCM_RARE inline int orient3d(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d,
                                    PredicateState& state) {
  const int filtered = orient3dFiltered(a, b, c, d);
  if (filtered != kUncertain) return filtered;
  if (state.mode == Predicates::kConservative) {
    if (!haveEqual(b, c, d)) state.undecided = true;
    return 0;
  }
  ++state.exact;
  return orient3dExact(a, b, c, d);
}

// Does the same as orient3d() for the plane through a, b and c, whose normal several points share.
DCM_HD DCM_RARE inline int sideOfPlane(const ErrorFreePlane& plane, const Vec3f& a, const Vec3f& b,
                                       const Vec3f& c, const Vec3f& d, PredicateState& state) {
  const int side = state.mode == Predicates::kExact ? plane.side(d) : kUncertain;
  if (side == kUncertain) return orient3d(a, b, c, d, state);
  if (side == 0) ++state.exact;
  return side;
}

// Returns the sign of det[b-a; c-a] by exact sums alone.
DCM_HD inline int orient2dExpanded(float ax, float ay, float bx, float by, float cx, float cy) {
  Expansion<6> sum;  // each product of two float32 is exact in double
  sum.add(static_cast<double>(ax) * by);
  sum.add(-static_cast<double>(ay) * bx);
  sum.add(static_cast<double>(bx) * cy);
  sum.add(-static_cast<double>(by) * cx);
  sum.add(static_cast<double>(cx) * ay);
  sum.add(-static_cast<double>(cy) * ax);
  return sum.sign();
}

// Returns the exact sign of det[b-a; c-a], by integers where they suffice.
DCM_HD DCM_RARE inline int orient2dInIntegers(float ax, float ay, float bx, float by, float cx,
                                              float cy) {
#if DCM_INT128
  const float x[6] = {ax, ay, bx, by, cx, cy};
  std::int64_t i[6];
  if (toIntegers(x, i)) {
    return determinantSign2(i[2] - i[0], i[3] - i[1], i[4] - i[0], i[5] - i[1]);
  }
#endif
  return orient2dExpanded(ax, ay, bx, by, cx, cy);
}

// Returns the sign of det[b-a; c-a] by double arithmetic, or kUncertain. If double holds the
// differences exactly, each product is the sum of its rounded value and the error of that. The
// greater product has the greater rounded value, or if these are equal the greater error.
DCM_HD inline int orient2dErrorFree(float ax, float ay, float bx, float by, float cx, float cy) {
  detail::ErrorFree<double> check;
  const double ux = check.difference(bx, ax), uy = check.difference(by, ay);
  const double vx = check.difference(cx, ax), vy = check.difference(cy, ay);
  const double left = ux * vy, right = uy * vx;
  constexpr double kBound = 3.3306690738754716e-16;  // as in orient2dFiltered()
  const double det = left - right, bound = kBound * (fabs(left) + fabs(right));
  if (det > bound) return 1;
  if (-det > bound) return -1;
  if (!check.exact) return kUncertain;
  return left != right ? signOf(det) : signOf(fma(ux, vy, -left) - fma(uy, vx, -right));
}

// Returns the exact sign of det[b-a; c-a], by doubles where they suffice.
DCM_HD DCM_RARE inline int orient2dExact(float ax, float ay, float bx, float by, float cx,
                                         float cy) {
  const int sign = orient2dErrorFree(ax, ay, bx, by, cx, cy);
  return sign != kUncertain ? sign : orient2dInIntegers(ax, ay, bx, by, cx, cy);
}

// Computes the coordinates of a projection along coordinate axis `axis` (0, 1, 2).
DCM_HD inline void projected(const Vec3f& p, int axis, float& x, float& y) {
  x = axis == 0 ? p.y : (axis == 1 ? p.z : p.x);
  y = axis == 0 ? p.z : (axis == 1 ? p.x : p.y);
}

// Returns the sign of det[b-a; c-a] of the points' projections along `axis` by double arithmetic,
// or kUncertain.
DCM_HD inline int orient2dFiltered(const Vec3f& a, const Vec3f& b, const Vec3f& c, int axis) {
  float ax, ay, bx, by, cx, cy;
  projected(a, axis, ax, ay);
  projected(b, axis, bx, by);
  projected(c, axis, cx, cy);
  const double left = (static_cast<double>(bx) - ax) * (static_cast<double>(cy) - ay);
  const double right = (static_cast<double>(by) - ay) * (static_cast<double>(cx) - ax);
  constexpr double kBound = 3.3306690738754716e-16;  // (3 + 16 eps) eps
  const double det = left - right, bound = kBound * (fabs(left) + fabs(right));
  if (det > bound) return 1;
  if (-det > bound) return -1;
  return left == 0 && right == 0 ? 0 : kUncertain;  // differences are never rounded to zero
}

// Returns the sign of det[b-a; c-a] of the points' projections along `axis`, as state.mode asks
// for.
DCM_HD DCM_RARE inline int orient2d(const Vec3f& a, const Vec3f& b, const Vec3f& c, int axis,
                                    PredicateState& state) {
  const int filtered = orient2dFiltered(a, b, c, axis);
  if (filtered != kUncertain) return filtered;
  if (state.mode == Predicates::kConservative) {
    if (!(b == c)) state.undecided = true;
    return 0;
  }
  ++state.exact;
  float ax, ay, bx, by, cx, cy;
  projected(a, axis, ax, ay);
  projected(b, axis, bx, by);
  projected(c, axis, cx, cy);
  return orient2dExact(ax, ay, bx, by, cx, cy);
}

}  // namespace deformable_contact_monitor
