// Float32 filters for pairs of moving triangles, with one pair in each vector lane.
//
// LaneSides tests vertices against planes that move; LaneMotion tests directions at a moment, or in
// a piece of the time interval. A lane of a mask is set only where its answer is certain. Infinite
// numbers and NaN leave it unset. u is 2^-24 in all error bounds.
#pragma once

#include <cstddef>

#include "core/cpu/lane_triangle.h"
#include "core/predicates/swept_polynomials.h"
#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

constexpr std::size_t kLanes = sizeof(FloatLanes) / sizeof(float);

template <>
struct Rounding<FloatLanes> : Rounding<float> {};

using LaneVector = Vector<FloatLanes>;

// A pair of triangles in each lane, at both ends of the time interval.
struct LanePairs {
  struct State {
    LaneVector a[3], b[3];
  } from, to;

  LanePairs(const MovingTriangle* const (&a)[kLanes], const MovingTriangle* const (&b)[kLanes]) {
    for (int i = 0; i < 3; ++i) {
      from.a[i] = spread([&a, i](int lane) -> const Vec3f& { return a[lane]->from.v[i]; });
      from.b[i] = spread([&b, i](int lane) -> const Vec3f& { return b[lane]->from.v[i]; });
      to.a[i] = spread([&a, i](int lane) -> const Vec3f& { return a[lane]->to.v[i]; });
      to.b[i] = spread([&b, i](int lane) -> const Vec3f& { return b[lane]->to.v[i]; });
    }
  }

 private:
  template <class Points>
  static LaneVector spread(const Points& at) {
    const Vec3f &p = at(0), &q = at(1), &r = at(2), &s = at(3);
    return {{FloatLanes{p.x, q.x, r.x, s.x}, FloatLanes{p.y, q.y, r.y, s.y},
             FloatLanes{p.z, q.z, r.z, s.z}}};
  }
};

// Returns p - q in each lane.
inline LaneVector minus(const LaneVector& p, const LaneVector& q) {
  return {{p.x[0] - q.x[0], p.x[1] - q.x[1], p.x[2] - q.x[2]}};
}

// The vertices of one triangle of each pair against the moving plane of the other. Each side is a
// cubic in time in Bernstein form, so that its sign is certain if all coefficients have it.
struct LaneSides {
  IntLanes apart;                             // strictly on one side at all times
  IntLanes on_both_at_start, on_both_at_end;  // strictly, some on one and some on the other

  LaneSides(const LaneVector (&plane_from)[3], const LaneVector (&plane_to)[3],
            const LaneVector (&from)[3], const LaneVector (&to)[3]) {
    const auto away = [&plane_from, &plane_to](const LaneVector& p, const LaneVector& q) {
      return MovingVector<FloatLanes>(minus(p, plane_from[0]), minus(q, plane_to[0]));
    };
    const MovingNormal<FloatLanes> normal(away(plane_from[1], plane_to[1]),
                                          away(plane_from[2], plane_to[2]));
    const MovingVector<FloatLanes> w[3] = {away(from[0], to[0]), away(from[1], to[1]),
                                           away(from[2], to[2])};
    Cubic<FloatLanes> d[3];
    determinantsOf(normal, w, d);
    const FloatLanes error = d[0].error;  // of all three
    IntLanes above[4], below[4];          // all of one coefficient
    FloatLanes low[4], high[4];
    for (int k = 0; k < 4; ++k) {
      low[k] = least(least(d[0].c[k], d[1].c[k]), d[2].c[k]);
      high[k] = most(most(d[0].c[k], d[1].c[k]), d[2].c[k]);
      above[k] = low[k] > error;
      below[k] = high[k] < -error;
    }
    apart =
        (above[0] & above[1] & above[2] & above[3]) | (below[0] & below[1] & below[2] & below[3]);
    on_both_at_start = (low[0] < -error) & (high[0] > error);
    on_both_at_end = (low[3] < -error) & (high[3] > error);
  }
};

// Vertices at one time, relative to the first vertex of a: the other two of a, and those of b.
struct LanePlaces {
  LaneVector a[2], b[3];
};

// Tells how the two triangles lie along a direction: the gap from a to b (`b_beyond`), and the gap
// from b to a. At most one of them is positive.
struct LaneOrder {
  FloatLanes b_beyond, a_beyond;

  LaneOrder(const LanePlaces& places, const LaneVector& n) {
    const FloatLanes a1 = dotOf(n, places.a[0]), a2 = dotOf(n, places.a[1]);
    const FloatLanes b0 = dotOf(n, places.b[0]), b1 = dotOf(n, places.b[1]),
                     b2 = dotOf(n, places.b[2]);
    b_beyond = least(least(b0, b1), b2) - most(most(a1, a2), FloatLanes{});
    a_beyond = least(least(a1, a2), FloatLanes{}) - most(most(b0, b1), b2);
  }
};

// Calls use(direction, is_needed) until it returns false. The directions are the line of centres
// and the eleven of the separating axis theorem: two face normals, and nine cross products of
// edges. is_needed is true for the eleven: triangles in general position that are disjoint are
// disjoint along one of these.
template <class Use>
inline void forEachDirection(const LanePlaces& p, const Use& use) {
  const LaneVector edge_a[3] = {p.a[0], p.a[1], minus(p.a[1], p.a[0])};
  const LaneVector edge_b[3] = {minus(p.b[1], p.b[0]), minus(p.b[2], p.b[0]),
                                minus(p.b[2], p.b[1])};
  const LaneVector centres = minus(sumOf(sumOf(p.b[0], p.b[1]), p.b[2]), sumOf(p.a[0], p.a[1]));
  if (!use(centres, false) || !use(crossOf(edge_a[0], edge_a[1]), true) ||
      !use(crossOf(edge_b[0], edge_b[1]), true)) {
    return;
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (!use(crossOf(edge_a[i], edge_b[j]), true)) return;
    }
  }
}

// Results that are certain about a piece of the time interval.
struct LanePiece {
  IntLanes meet;                             // in the middle of it
  IntLanes apart_in_first, apart_in_second;  // at all times of its halves
};

// The motion of each pair, seen from a's first vertex; it is linear in time too. With R the largest
// size of a coordinate, a vertex is off by at most 3 u R (difference, products, sum).
class LaneMotion {
 public:
  explicit LaneMotion(const LanePairs& pairs) {
    setPlaces(pairs.from, from_);
    setPlaces(pairs.to, to_);
    for (int k = 0; k < 3; ++k) {
      const FloatLanes of_b2_from = sizeOf(from_.b[2].x[k]), of_b2_to = sizeOf(to_.b[2].x[k]);
      reach_.x[k] = greatest(reachOfFour(from_, k), of_b2_from, reachOfFour(to_, k), of_b2_to) +
                    Rounding<float>::kProduct;
    }
    // Errors of the directions: an edge is off by 8 u R, of at most 2 R; a component of a cross
    // product of two edges by 80 u R R, of at most 8 R R; its product with a vertex by 112 u R R R.
    // The difference of two sums of three such products is off by 816 u R R R.
    for (int k = 0; k < 3; ++k) {
      const int i = k == 2 ? 0 : k + 1, j = k == 0 ? 2 : k - 1;
      volume_error_ += 290 * Rounding<float>::kUnit * reach_.x[k] *
                       (reach_.x[i] * reach_.x[j] + Rounding<float>::kProduct);
    }
  }

  // Returns where a pair certainly meets at time t: it overlaps along all needed directions by more
  // than the error.
  IntLanes meet(const FloatLanes& t) const {
    const LanePlaces places = at(t);
    IntLanes all = ~IntLanes{};
    forEachDirection(places, [&](const LaneVector& n, bool is_needed) {
      if (!is_needed) return true;
      const LaneOrder order(places, n);
      const FloatLanes overlap = -(errorAlong(n) + volume_error_);
      all &= (order.b_beyond < overlap) & (order.a_beyond < overlap);
      return laneBits(all) != 0;
    });
    return all;
  }

  // Tests a piece of the time interval that begins at `low`. It uses the directions of the
  // middle of the piece.
  LanePiece piece(const FloatLanes& low, float width) const {
    const LanePlaces start = at(low), middle = at(low + width / 2), end = at(low + width);
    LanePiece piece{~IntLanes{}, IntLanes{}, IntLanes{}};
    forEachDirection(middle, [&](const LaneVector& n, bool is_needed) {
      const FloatLanes error = errorAlong(n);
      const LaneOrder order(middle, n);
      const IntLanes b_beyond = order.b_beyond > error, a_beyond = order.a_beyond > error;
      if (is_needed) {
        const FloatLanes overlap = -(error + volume_error_);
        piece.meet &= (order.b_beyond < overlap) & (order.a_beyond < overlap);
      }
      if (laneBits(b_beyond | a_beyond) == 0) return true;
      // Two triangles that are apart along n at two times, on the same side, are so at all times
      // between: differences of projections are linear in time.
      const LaneOrder before(start, n), after(end, n);
      piece.apart_in_first |=
          (b_beyond & (before.b_beyond > error)) | (a_beyond & (before.a_beyond > error));
      piece.apart_in_second |=
          (b_beyond & (after.b_beyond > error)) | (a_beyond & (after.a_beyond > error));
      return laneBits(piece.apart_in_first & piece.apart_in_second) != 15;
    });
    piece.meet &= ~(piece.apart_in_first | piece.apart_in_second);
    return piece;
  }

 private:
  static void setPlaces(const LanePairs::State& state, LanePlaces& places) {
    for (int i = 0; i < 2; ++i) places.a[i] = minus(state.a[i + 1], state.a[0]);
    for (int i = 0; i < 3; ++i) places.b[i] = minus(state.b[i], state.a[0]);
  }

  // Returns the largest coordinate of four of the five vertices; the caller adds b's last one.
  static FloatLanes reachOfFour(const LanePlaces& p, int k) {
    return greatest(sizeOf(p.a[0].x[k]), sizeOf(p.a[1].x[k]), sizeOf(p.b[0].x[k]),
                    sizeOf(p.b[1].x[k]));
  }

  // Returns the vertices at time t.
  LanePlaces at(const FloatLanes& t) const {
    const FloatLanes s = 1 - t;
    const auto between = [&s, &t](const LaneVector& p, const LaneVector& q) -> LaneVector {
      return {{p.x[0] * s + q.x[0] * t, p.x[1] * s + q.x[1] * t, p.x[2] * s + q.x[2] * t}};
    };
    LanePlaces places;
    for (int i = 0; i < 2; ++i) places.a[i] = between(from_.a[i], to_.a[i]);
    for (int i = 0; i < 3; ++i) places.b[i] = between(from_.b[i], to_.b[i]);
    return places;
  }

  // Bounds the error of the difference of two projections along n: 6 u of the projection of R for
  // each. It becomes infinite before a projection does.
  FloatLanes errorAlong(const LaneVector& n) const {
    const FloatLanes size = sizeOfDot(reach_, n);
    return 8 * Rounding<float>::kUnit * (size + size) + Rounding<float>::kSum;
  }

  LanePlaces from_, to_;
  LaneVector reach_;
  FloatLanes volume_error_{};
};

}  // namespace deformable_contact_monitor
