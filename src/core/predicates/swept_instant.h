// Moving points at an exact instant, a root of a polynomial as it may be: they have signs of
// orientations, comparisons and equality, so that the static predicates (segment_intersection.h,
// adjacency.h) hold for them as for float32 points. Host only.
#pragma once

#include <vector>

#include "core/predicates/orientation.h"
#include "core/predicates/real_root.h"
#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

// Differences and orientation determinants of moving points as polynomials in time, in integers:
// all coordinates are scaled by one power of two.
class ExactMotion {
 public:
  // Finite points.
  ExactMotion(const MovingPoint* points, int count);

  int count() const { return count_; }
  Polynomial difference(int a, int b, int axis) const;          // b - a along `axis`
  Polynomial orientation(int a, int b, int c, int axis) const;  // det[b-a; c-a], projected
  Polynomial orientation3(int a, int b, int c, int d) const;    // det[b-a; c-a; d-a]

 private:
  int count_;
  std::vector<GrowingInteger> from_, to_;  // three for each point
};

struct Instant {
  const ExactMotion* motion = nullptr;
  RealRoot* time = nullptr;
};

// A point of that motion at that time; both must stay alive.
struct PointAt {
  const Instant* instant = nullptr;
  int index = 0;

  int signOf(const Polynomial& p) const { return instant->time->signOf(p); }
  int compare(const PointAt& other, int axis) const {
    return signOf(instant->motion->difference(other.index, index, axis));
  }
};

// As Triangle.
struct TriangleAt {
  PointAt v[3];
};

inline bool operator==(const PointAt& a, const PointAt& b) {
  return a.compare(b, 0) == 0 && a.compare(b, 1) == 0 && a.compare(b, 2) == 0;
}
inline bool operator!=(const PointAt& a, const PointAt& b) { return !(a == b); }

inline bool inBox(const PointAt& p, const PointAt& a, const PointAt& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (p.compare(a, axis) * p.compare(b, axis) > 0) return false;
  }
  return true;
}

inline int orient2d(const PointAt& a, const PointAt& b, const PointAt& c, int axis,
                    PredicateState& /*state*/) {
  return a.signOf(a.instant->motion->orientation(a.index, b.index, c.index, axis));
}

inline int orient3d(const PointAt& a, const PointAt& b, const PointAt& c, const PointAt& d,
                    PredicateState& /*state*/) {
  return a.signOf(a.instant->motion->orientation3(a.index, b.index, c.index, d.index));
}

inline int orient3dFiltered(const PointAt& /*a*/, const PointAt& /*b*/, const PointAt& /*c*/,
                            const PointAt& /*d*/) {
  return kUncertain;
}

}  // namespace deformable_contact_monitor
