// Decides features of two moving triangles by integers, where double leaves them open.
//
// integerSigns() counts the roots of a feature's cubic. tieVerdict() knows the two ways in which
// real meshes meet without a strict sign. Two vertices come together; or a vertex comes to an edge,
// and the three points always have one coordinate in common. The latter is so in meshes with a
// plane of symmetry, on level tables, and between boxes with parallel sides. Such meetings are
// roots of linear functions and of quadratics, which need 126 bits.
#pragma once

#include <cstdint>

#include "core/predicates/exact_integers.h"
#include "core/predicates/orientation.h"
#include "core/predicates/swept_feature.h"

namespace deformable_contact_monitor {

// The exact signs' answer about the determinant [x1 - x0, x2 - x0, x3 - x0].
enum class IntegerSigns {
  kUnknown,       // none of the others, or the integers are too large
  kNoRootWithin,  // it does not vanish in (0, 1); it may at 0 and at 1
  kOneRoot,       // it vanishes once in [0, 1], and not at 0 or 1
};

#if DCM_INT128
namespace detail {

// Up to five moving points as integers, in a common unit; all are less than 2^61.
struct IntegerPoints {
  static constexpr int kPoints = 5;
  std::int64_t n[6 * kPoints];  // all at the start, then all at the end
  bool fit;

  // The points of a feature and `more`.
  DCM_HD IntegerPoints(const Feature& feature, const MovingPoint& more) {
    float x[6 * kPoints];
    for (int i = 0; i < kPoints; ++i) {
      const MovingPoint& p = i < 4 ? feature.x[i] : more;
      for (int k = 0; k < 3; ++k) {
        x[3 * i + k] = p.from[k];
        x[3 * (i + kPoints) + k] = p.to[k];
      }
    }
    fit = toIntegers(x, n);
  }

  // Returns a coordinate of q - p at the start or at the end.
  DCM_HD std::int64_t difference(int p, int q, int axis, bool at_end) const {
    const int first = at_end ? 3 * kPoints : 0;
    return n[first + 3 * q + axis] - n[first + 3 * p + axis];
  }
};

// Adds the determinant [u v w]; each number is less than 2^62 in size. The sum of three
// determinants fits.
DCM_HD inline void addDeterminant(Int192& sum, const std::int64_t u[3], const std::int64_t v[3],
                                  const std::int64_t w[3]) {
  sum.addProduct(static_cast<Int128>(v[1]) * w[2] - static_cast<Int128>(v[2]) * w[1], u[0]);
  sum.addProduct(static_cast<Int128>(v[2]) * w[0] - static_cast<Int128>(v[0]) * w[2], u[1]);
  sum.addProduct(static_cast<Int128>(v[0]) * w[1] - static_cast<Int128>(v[1]) * w[0], u[2]);
}

constexpr std::int64_t kTimeUnits = 1 << kMostHalvings;  // in [0, 1]

// Returns the sign of a difference of coordinates on the closed interval [k, k + 1] / kTimeUnits: 0
// if it is always 0, kUncertain if it has no strict sign there.
DCM_HD inline int signWithin(std::int64_t at_start, std::int64_t at_end, std::int64_t k) {
  if (at_start == 0 && at_end == 0) return 0;
  const Int128 first = Int128{at_start} * (kTimeUnits - k) + Int128{at_end} * k;
  const Int128 second = first - at_start + at_end;
  if (first > 0 && second > 0) return 1;
  return first < 0 && second < 0 ? -1 : kUncertain;
}

__extension__ using UInt128 = unsigned __int128;

// The product of two integers.
class Product256 {
 public:
  DCM_HD Product256(Int128 x, Int128 y) : negative_((x < 0) != (y < 0)) {
    const UInt128 a = x < 0 ? -UInt128(x) : UInt128(x), b = y < 0 ? -UInt128(y) : UInt128(y);
    const UInt128 low = half(a) * half(b), cross = half(a >> 64) * half(b);
    const UInt128 other = half(a) * half(b >> 64), high = half(a >> 64) * half(b >> 64);
    const UInt128 middle = (low >> 64) + half(cross) + half(other);
    low_ = middle << 64 | half(low);
    high_ = high + (cross >> 64) + (other >> 64) + (middle >> 64);
  }
  DCM_HD bool operator==(const Product256& other) const {
    return low_ == other.low_ && high_ == other.high_ &&
           (negative_ == other.negative_ || (low_ == 0 && high_ == 0));
  }

 private:
  DCM_HD static UInt128 half(UInt128 x) { return static_cast<std::uint64_t>(x); }

  UInt128 low_, high_;
  bool negative_;
};

// A quadratic in time with the Bernstein coefficients c[0], c[1] / 2 and c[2], each less than 2^126
// in size.
struct IntegerQuadratic {
  Int128 c[3];

  DCM_HD bool changesSign() const { return (c[0] < 0 && c[2] > 0) || (c[0] > 0 && c[2] < 0); }

  // Returns the sign at k / kTimeUnits.
  DCM_HD int signAt(std::int64_t k) const {
    const std::int64_t rest = kTimeUnits - k;
    Int192 sum;
    sum.addProduct(c[0], rest * rest);
    sum.addProduct(c[1], rest * k);
    sum.addProduct(c[2], k * k);
    return sum.sign();
  }

  // Returns whether this is a constant times `other`, which is not 0.
  DCM_HD bool isMultipleOf(const IntegerQuadratic& other) const {
    return Product256(c[0], other.c[1]) == Product256(c[1], other.c[0]) &&
           Product256(c[0], other.c[2]) == Product256(c[2], other.c[0]) &&
           Product256(c[1], other.c[2]) == Product256(c[2], other.c[1]);
  }

  // Finds the k for which [k, k + 1] / kTimeUnits has the only root of a quadratic that changes its
  // sign. It computes in double first. Returns -1 if rounding misled that.
  DCM_HD std::int64_t rootPlace() const {
    const int sign = c[0] > 0 ? 1 : -1;
    const double a = sign * rounded(c[0]), b = sign * 0.5 * rounded(c[1]), d = sign * rounded(c[2]);
    std::int64_t k = 0;
    for (std::int64_t half = kTimeUnits / 2; half > 0; half /= 2) {
      const double t = static_cast<double>(k + half) / kTimeUnits, s = 1 - t;
      if (s * (s * a + t * b) + t * (s * b + t * d) > 0) k += half;
    }
    return signAt(k) * sign >= 0 && signAt(k + 1) * sign <= 0 ? k : -1;
  }

 private:
  DCM_HD static double rounded(Int128 x) {
    const Int128 size = x < 0 ? -x : x;
    const double rounded_size =
        static_cast<double>(static_cast<std::uint64_t>(size >> 64)) * 0x1p64 +
        static_cast<double>(static_cast<std::uint64_t>(size));
    return x < 0 ? -rounded_size : rounded_size;
  }
};

// Finds when the points v and w, which differ at the start and at the end, come together. Returns
// the interval as rootPlace() does, or -1.
DCM_HD inline std::int64_t whenTogether(const IntegerPoints& points, int v, int w) {
  std::int64_t from[3], to[3];
  int changing = -1;
  for (int k = 0; k < 3; ++k) {
    from[k] = points.difference(v, w, k, false);
    to[k] = points.difference(v, w, k, true);
    if ((from[k] < 0 && to[k] > 0) || (from[k] > 0 && to[k] < 0)) changing = k;
  }
  if (changing < 0) return -1;
  for (int k = 0; k < 3; ++k) {
    if (Int128{from[k]} * to[changing] != Int128{to[k]} * from[changing]) return -1;
  }
  const std::int64_t a = from[changing], b = to[changing];
  return IntegerQuadratic{{a, Int128{a} + b, b}}.rootPlace();
}

// Returns the cross product of the ways from p to q and from p to v, projected along `axis`.
DCM_HD inline IntegerQuadratic turnOf(const IntegerPoints& points, int v, int p, int q, int axis) {
  const int i = axis == 2 ? 0 : axis + 1, j = axis == 0 ? 2 : axis - 1;
  Int128 turn[2][2];  // the state of pq, and that of pv
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      turn[a][b] = Int128{points.difference(p, q, i, a != 0)} * points.difference(p, v, j, b != 0) -
                   Int128{points.difference(p, q, j, a != 0)} * points.difference(p, v, i, b != 0);
    }
  }
  return {{turn[0][0], turn[0][1] + turn[1][0], turn[1][1]}};
}

// Returns whether v, known to lie on the line pq at some time in [k, k + 1] / kTimeUnits, is then
// certainly on the edge: so it is along an axis that does not flatten the edge.
DCM_HD inline bool isBetween(const IntegerPoints& points, int v, int p, int q, std::int64_t k) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto sign = [&points, axis, k](int a, int b) {
      return signWithin(points.difference(a, b, axis, false), points.difference(a, b, axis, true),
                        k);
    };
    const int before = sign(p, v), after = sign(v, q);
    if (isStrict(sign(p, q)) && before != kUncertain && after != kUncertain) {
      return before * after >= 0;
    }
  }
  return false;
}

// Finds when v comes to the edge pq, if the normal of the three points keeps its direction: then
// they are on one line when one of its coordinates is 0. Returns the interval as rootPlace() does,
// or -1.
DCM_HD inline std::int64_t whenOnEdge(const IntegerPoints& points, int v, int p, int q) {
  IntegerQuadratic turn[3];
  int changing = -1;
  for (int axis = 0; axis < 3; ++axis) {
    turn[axis] = turnOf(points, v, p, q, axis);
    if (turn[axis].changesSign()) changing = axis;
  }
  if (changing < 0) return -1;
  for (int axis = 0; axis < 3; ++axis) {
    if (!turn[axis].isMultipleOf(turn[changing])) return -1;
  }
  const std::int64_t k = turn[changing].rootPlace();
  return k >= 0 && isBetween(points, v, p, q, k) ? k : -1;
}

// Returns whether v and w are certainly apart on [k, k + 1] / kTimeUnits.
DCM_HD inline bool areApartWithin(const IntegerPoints& points, int v, int w, std::int64_t k) {
  bool apart = false;
  for (int axis = 0; axis < 3; ++axis) {
    apart = apart || isStrict(signWithin(points.difference(v, w, axis, false),
                                         points.difference(v, w, axis, true), k));
  }
  return apart;
}

// Returns the first interval [k, k + 1] / kTimeUnits in which a tie of the feature lies, or -1. If
// `beyond` is set, the parts must meet in another point than the fifth.
DCM_HD inline std::int64_t firstTie(const Feature& feature, const IntegerPoints& points,
                                    bool beyond) {
  const bool face = feature.kind == FeatureKind::kVertexFace;
  std::int64_t first = -1;
  DCM_ROLLED for (int i = 0; i < (face ? 3 : 4); ++i) {
    const int v = face ? 3 : i;
    const int p = face ? i : (i < 2 ? 2 : 0), q = face ? (i == 2 ? 0 : i + 1) : p + 1;
    const int other = face ? i : (i < 2 ? 2 + i : 3 - i);  // each vertex with each
    DCM_ROLLED for (int kind = 0; kind < 2; ++kind) {
      const std::int64_t k =
          kind == 0 ? whenOnEdge(points, v, p, q) : whenTogether(points, v, other);
      if (k < 0 || (first >= 0 && first <= k)) continue;
      if (!beyond || areApartWithin(points, v, 4, k)) first = k;
    }
  }
  return first;
}

}  // namespace detail

DCM_HD DCM_RARE inline IntegerSigns integerSigns(const Feature& feature) {
  const detail::IntegerPoints points(feature, feature.x[0]);
  if (!points.fit) return IntegerSigns::kUnknown;
  std::int64_t edge[2][3][3];
  for (int end = 0; end < 2; ++end) {
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) edge[end][i][k] = points.difference(0, i + 1, k, end != 0);
    }
  }
  // Each Bernstein coefficient is a sum over the choices of which of the three differences are
  // taken at the end of the interval.
  int variations = 0, last = 0, first = 0, vanishing = 0;
  DCM_ROLLED for (int later = 0; later < 4; ++later) {
    Int192 sum;
    DCM_ROLLED for (int which = 0; which < 8; ++which) {
      const int u = which & 1, v = which >> 1 & 1, w = which >> 2;
      if (u + v + w == later) detail::addDeterminant(sum, edge[u][0], edge[v][1], edge[w][2]);
    }
    const int sign = sum.sign();
    vanishing += sign == 0 && (later == 0 || later == 3);
    if (sign == 0) continue;
    if (first == 0) first = sign;
    variations += last != 0 && sign != last;
    last = sign;
  }
  // By Descartes' rule of signs there are no more roots in (0, 1) than sign changes, and as many if
  // there is one change, unless the cubic is always zero.
  if (first != 0 && variations == 0) return IntegerSigns::kNoRootWithin;
  return variations == 1 && vanishing == 0 ? IntegerSigns::kOneRoot : IntegerSigns::kUnknown;
}

// Decides a feature that does not meet before `low`, if it meets in a tie. With `one_root`, its
// cubic vanishes only once. If `shared` is set, only meetings in another point than this one count.
// As halvedVerdict(), it returns any time at which the feature has met unless `wants_time`.
DCM_HD DCM_RARE inline FeatureVerdict tieVerdict(const Feature& feature, const MovingPoint* shared,
                                                 float low, bool wants_time, bool one_root) {
  const FeatureVerdict open{PartVerdict::kOpen, low, 1};
  if (feature.kind == FeatureKind::kFold) return open;
  const detail::IntegerPoints points(feature, shared != nullptr ? *shared : feature.x[0]);
  const std::int64_t k = points.fit ? detail::firstTie(feature, points, shared != nullptr) : -1;
  if (k < 0) return open;
  const float start = static_cast<float>(k) / detail::kTimeUnits;
  const float end = static_cast<float>(k + 1) / detail::kTimeUnits;
  if (one_root || !wants_time) return {PartVerdict::kMeet, start, end};
  return end - low <= kTimeWidth ? FeatureVerdict{PartVerdict::kMeet, least(low, start), end}
                                 : open;
}
#else
DCM_HD inline IntegerSigns integerSigns(const Feature& /*feature*/) {
  return IntegerSigns::kUnknown;
}
DCM_HD inline FeatureVerdict tieVerdict(const Feature& /*feature*/, const MovingPoint* /*shared*/,
                                        float low, bool /*wants_time*/, bool /*one_root*/) {
  return {PartVerdict::kOpen, low, 1};
}
#endif

}  // namespace deformable_contact_monitor
