// Decides whether two triangles that move on straight lines come within a motion bound ("pad") of
// each other. The bound is for links that rotate: their points move on arcs, and stay within the
// bound of the straight lines.
//
// Triangles that are farther apart than the pad may also count as within it: the test gives up
// after ten halvings, when they are at most the pad and 1/2048 of their way apart, where the way is
// how far a vertex of one moves as seen from the other. It gives up sooner, and at a larger part of
// the way, where 100 intervals were not enough.
//
// Two triangles are more than the pad apart during an interval if, along some fixed direction n,
// one lies beyond the other by more than pad |n| at both ends: differences of projections are
// linear in time. n is the direction of their shortest distance in the middle of the interval, so
// that the test only loses what this direction rotates. Intervals are halved, earlier halves first,
// until all are apart, or one is short and still open.
//
// Rounding, with u = 2^-53 and m the largest size of a coordinate relative to a's first vertex: the
// subtraction leaves u m, the difference of two states 4 u m, interpolation 8 u m. A projection is
// off by 3 u more of s, the sum of |n_k| m_k; two projections and their difference are off by less
// than 24 u s. |n| is right to 4 u. Nothing overflows: coordinates are below 2^129, a direction
// below 2^260. Where the direction is above 2^-300, underflow is far less than the room that the
// constants below leave.
#pragma once

#include <cmath>

#include "core/predicates/swept_triangle.h"
#include "core/predicates/triangle_distance.h"

namespace deformable_contact_monitor {

// The decision on a pair.
struct PadVerdict {
  bool may_touch = false;
  float first_low = 0;  // certainly more than the pad apart in [0, first_low)
};

namespace detail {

// Returns x / whole, clamped to [0, 1].
DCM_HD inline double partOf(double x, double whole) {
  return whole > 0 ? least(most(x / whole, 0.0), 1.0) : 0.0;
}

// The shortest vector so far from one set of points to another. Its length is kept apart, because
// `way` may have any length.
struct ShortestWay {
  Vec3d way;
  double squared = INFINITY;

  DCM_HD void take(double squared_length, const Vec3d& along) {
    if (!(squared_length < squared)) return;
    squared = squared_length;
    way = along;
  }

  // Tries the segment from p to p + u with the segment from q to q + v.
  DCM_HD void trySegments(const Vec3d& p, const Vec3d& u, const Vec3d& q, const Vec3d& v) {
    const Vec3d w = p - q;
    const double uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), uw = dot(u, w), vw = dot(v, w);
    double on_p = partOf(uv * vw - uw * vv, uu * vv - uv * uv);
    const double on_q = partOf(uv * on_p + vw, vv);
    on_p = partOf(uv * on_q - uw, uu);
    const Vec3d along = (q + v * on_q) - (p + u * on_p);
    take(dot(along, along), along);
  }

  // Tries the point p with the inside of a triangle; the vector is multiplied by `sign`.
  DCM_HD void tryFace(const Vec3d& p, const Vec3d (&t)[3], double sign) {
    const Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
    bool inside = true;
    for (int i = 0; i < 3; ++i) {
      const Vec3d edge = t[i == 2 ? 0 : i + 1] - t[i];
      inside = inside && dot(cross(edge, p - t[i]), normal) >= 0;
    }
    const double size2 = dot(normal, normal), height = dot(t[0] - p, normal);
    if (!inside || !(size2 > 0)) return;
    take(height * height / size2, normal * (height < 0 ? -sign : sign));
  }
};

// Two moving triangles, relative to a point that moves with the first.
class RecentredPair {
 public:
  DCM_HD RecentredPair(const MovingTriangle& a, const MovingTriangle& b)
      : a_(a), b_(b), from_(toDouble(a.from.v[0])), to_(toDouble(a.to.v[0])) {
    DCM_ROLLED for (int i = 0; i < 3; ++i) {
      include(a_, i);
      include(b_, i);
    }
  }

  // Returns whether they are certainly more than the pad apart from time `low` to time `high`.
  DCM_HD bool areApart(double low, double high, float pad_m) const {
    const Vec3d n = wayAt((low + high) * 0.5);
    return isBeyond(n, low, pad_m) && isBeyond(n, high, pad_m);
  }

 private:
  DCM_HD Vec3d placeOf(const MovingTriangle& t, int i, double time) const {
    const Vec3d from = toDouble(t.from.v[i]) - from_, to = toDouble(t.to.v[i]) - to_;
    return from + (to - from) * time;
  }

  DCM_HD void include(const MovingTriangle& t, int i) {
    const Vec3d from = toDouble(t.from.v[i]) - from_, to = toDouble(t.to.v[i]) - to_;
    reach_.x = most(reach_.x, most(fabs(from.x), fabs(to.x)));
    reach_.y = most(reach_.y, most(fabs(from.y), fabs(to.y)));
    reach_.z = most(reach_.z, most(fabs(from.z), fabs(to.z)));
  }

  // Returns a vector along their shortest distance, from a to b. Where they intersect, it has no
  // meaning.
  DCM_HD Vec3d wayAt(double time) const {
    Vec3d a[3], b[3];
    for (int i = 0; i < 3; ++i) {
      a[i] = placeOf(a_, i, time);
      b[i] = placeOf(b_, i, time);
    }
    ShortestWay shortest;
    DCM_ROLLED for (int i = 0; i < 3; ++i) {
      const Vec3d u = a[i == 2 ? 0 : i + 1] - a[i];
      DCM_ROLLED for (int j = 0; j < 3; ++j) {
        shortest.trySegments(a[i], u, b[j], b[j == 2 ? 0 : j + 1] - b[j]);
      }
      shortest.tryFace(a[i], b, 1);
      shortest.tryFace(b[i], a, -1);
    }
    return shortest.way;
  }

  // Returns whether b is certainly beyond a along n, by more than the pad.
  DCM_HD bool isBeyond(const Vec3d& n, double time, float pad_m) const {
    double high_a = -INFINITY, low_b = INFINITY;
    for (int i = 0; i < 3; ++i) {
      high_a = most(high_a, dot(n, placeOf(a_, i, time)));
      low_b = least(low_b, dot(n, placeOf(b_, i, time)));
    }
    const double size2 = dot(n, n);
    const double sum = fabs(n.x) * reach_.x + fabs(n.y) * reach_.y + fabs(n.z) * reach_.z;
    constexpr double kUnit = 0x1p-53, kSmallest = 0x1p-600;
    return size2 > kSmallest &&
           low_b - high_a > pad_m * sqrt(size2) * (1 + 16 * kUnit) + 32 * kUnit * sum;
  }

  const MovingTriangle &a_, &b_;
  Vec3d from_, to_, reach_;
};

DCM_HD inline bool precedes(const MovingTriangle& a, const MovingTriangle& b) {
  return precedes(a.from, b.from) || (!precedes(b.from, a.from) && precedes(a.to, b.to));
}

DCM_HD DCM_RARE inline PadVerdict orderedWithinPad(const MovingTriangle& a, const MovingTriangle& b,
                                                   float pad_m) {
  constexpr int kMostHalvings = 10, kMostLooks = 100;
  const RecentredPair pair(a, b);
  unsigned index = 0;  // of the interval, of all of that length
  int halvings = 0;
  for (int look = 0;; ++look) {
    const double length = 1.0 / (1U << halvings), low = index * length;
    if (pair.areApart(low, low + length, pad_m)) {
      for (; index % 2 == 1; index /= 2) --halvings;
      if (halvings == 0) return {};
      ++index;
    } else if (halvings < kMostHalvings && look < kMostLooks) {
      index *= 2;
      ++halvings;
    } else {
      return {true, static_cast<float>(low)};
    }
  }
}

}  // namespace detail

// Decides two triangles with finite vertices. may_touch is false only if they are certainly more
// than `pad_m` > 0 apart at all times of the interval. The result has the same bits on host and
// device, and with a and b swapped.
DCM_HD inline PadVerdict withinPad(const MovingTriangle& a, const MovingTriangle& b, float pad_m) {
  MovingBox grown = boxOf(a);
  grown.from = inflated(grown.from, pad_m);
  grown.to = inflated(grown.to, pad_m);
  if (areApart(grown, boxOf(b))) return {};
  return detail::precedes(b, a) ? detail::orderedWithinPad(b, a, pad_m)
                                : detail::orderedWithinPad(a, b, pad_m);
}

}  // namespace deformable_contact_monitor
