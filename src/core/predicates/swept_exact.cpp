// Exact decisions about moving triangles.
//
// Triangles can only begin to meet at a time when some orientation determinant of their points is
// zero. These determinants are polynomials of degree 3 at most in time, with integer coefficients,
// whose roots real_root.h finds. At a root, PointAt has exact orientations, comparisons and
// equality, so that the static predicates (segment_intersection.h, adjacency.h) work on it as they
// do on float32 points.
#include "core/predicates/swept_exact.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/predicates/orientation.h"
#include "core/predicates/real_root.h"
#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {
namespace {

// Differences and orientation determinants of moving points, as polynomials in time. Coefficients
// are integers: all coordinates are scaled by the same power of two.
class ExactMotion {
 public:
  // The points must be finite.
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

// A point of the motion at that time. Both must outlive it.
struct PointAt {
  const Instant* instant = nullptr;
  int index = 0;

  int signOf(const Polynomial& p) const { return instant->time->signOf(p); }
  int compare(const PointAt& other, int axis) const {
    return signOf(instant->motion->difference(other.index, index, axis));
  }
};

// Three such points, as in Triangle.
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

// Splits x = mantissa * 2^exponent, |mantissa| < 2^24. Zero gets a large exponent.
std::int64_t mantissaOf(float x, int& exponent) {
  exponent = 1000;
  if (x == 0) return 0;
  const float fraction = std::frexp(x, &exponent);
  exponent -= 24;
  return static_cast<std::int64_t>(std::ldexp(fraction, 24));
}

std::size_t place(int point, int axis) {
  return 3 * static_cast<std::size_t>(point) + static_cast<std::size_t>(axis);
}

ExactMotion::ExactMotion(const MovingPoint* points, int count) : count_(count) {
  int low = 1000;
  for (int i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const float x : {points[i].from[axis], points[i].to[axis]}) {
        int exponent;
        mantissaOf(x, exponent);
        low = std::min(low, exponent);
      }
    }
  }
  const auto scaled = [low](float x) {
    int exponent;
    const std::int64_t mantissa = mantissaOf(x, exponent);
    return mantissa == 0 ? GrowingInteger(0) : GrowingInteger(mantissa) << (exponent - low);
  };
  for (int i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      from_.push_back(scaled(points[i].from[axis]));
      to_.push_back(scaled(points[i].to[axis]));
    }
  }
}

Polynomial ExactMotion::difference(int a, int b, int axis) const {
  const std::size_t i = place(a, axis), j = place(b, axis);
  const GrowingInteger start = from_[j] - from_[i];
  return Polynomial::linear(start, to_[j] - to_[i] - start);
}

Polynomial ExactMotion::orientation(int a, int b, int c, int axis) const {
  const int i = axis == 2 ? 0 : axis + 1, j = axis == 0 ? 2 : axis - 1;
  return difference(a, b, i) * difference(a, c, j) - difference(a, b, j) * difference(a, c, i);
}

Polynomial ExactMotion::orientation3(int a, int b, int c, int d) const {
  Polynomial sum;
  for (int axis = 0; axis < 3; ++axis) {
    sum = sum + orientation(a, b, c, axis) * difference(a, d, axis);
  }
  return sum;
}

void addTime(RealRoot& time, FirstTime& first) {
  first.low = least(first.low, time.floatLow());
  first.high = least(first.high, time.floatHigh());
}

// Adds the roots of f at which `happens` returns true. Without `wants_time` the first one is
// enough.
template <class Happens>
void addRoots(const ExactMotion& motion, const Polynomial& f, bool wants_time, FirstTime& first,
              const Happens& happens) {
  for (RealRoot& root : rootsInUnitInterval(f)) {
    if (!wants_time && first.happens()) return;
    const Instant instant{&motion, &root};
    if (happens(instant)) addTime(root, first);
  }
}

PointAt at(const Instant& instant, int index) { return {&instant, index}; }

// Adds the times at which two points that differ at t = 0 meet.
void addVertexOnVertex(const ExactMotion& motion, int p, int q, bool wants_time, FirstTime& first) {
  for (int axis = 0; axis < 3; ++axis) {
    const Polynomial apart = motion.difference(p, q, axis);
    if (apart.isZero()) continue;
    addRoots(motion, apart, wants_time, first,
             [p, q](const Instant& instant) { return at(instant, p) == at(instant, q); });
    return;
  }
}

// Adds the times at which p, not on the segment ab at t = 0, comes to it.
void addVertexOnEdge(const ExactMotion& motion, int p, int a, int b, bool wants_time,
                     FirstTime& first) {
  for (int axis = 0; axis < 3; ++axis) {
    const Polynomial orientation = motion.orientation(a, b, p, axis);
    if (orientation.isZero()) continue;
    addRoots(motion, orientation, wants_time, first, [p, a, b](const Instant& instant) {
      PredicateState state;
      return pointOnSegment(at(instant, p), at(instant, a), at(instant, b), state);
    });
    return;
  }
  // The three points are always on one line: p can only come in through an end.
  addVertexOnVertex(motion, p, a, wants_time, first);
  addVertexOnVertex(motion, p, b, wants_time, first);
}

bool meetsAt(FeatureKind kind, const Instant& instant) {
  PredicateState state;
  const PointAt x0 = at(instant, 0), x1 = at(instant, 1), x2 = at(instant, 2), x3 = at(instant, 3);
  if (kind == FeatureKind::kEdgeEdge) return segmentsIntersect(x0, x1, x2, x3, state);
  return segmentIntersectsTriangle(x3, x3, TriangleAt{{x0, x1, x2}}, state);
}

// Two triangles that share vertices, as indices of points in one motion.
class SharingPair {
 public:
  SharingPair(const MovingTriangle& a, const MovingTriangle& b, const SharedVertices& shared)
      : shared_(shared), split_(a, b, shared), motion_(points(), count()) {
    for (int i = 0, rest = split_.common_count; i < 3; ++i) {
      a_[i] = shared.in_a[i] ? indexOfCommon(a.point(i)) : rest++;
    }
    for (int i = 0, rest = split_.common_count + split_.a_count; i < 3; ++i) {
      b_[i] = shared.in_b[i] ? indexOfCommon(b.point(i)) : rest++;
    }
  }

  const SharedSplit& split() const { return split_; }
  const ExactMotion& motion() const { return motion_; }

  bool meetAt(RealRoot& time) const {
    const Instant instant{&motion_, &time};
    TriangleAt a, b;
    for (int i = 0; i < 3; ++i) {
      a.v[i] = at(instant, a_[i]);
      b.v[i] = at(instant, b_[i]);
    }
    PredicateState state;
    return meetBeyondShared(a, b, shared_, state);
  }

 private:
  int indexOfCommon(const MovingPoint& p) const {
    int i = 0;
    while (!(split_.common[i] == p)) ++i;
    return i;
  }
  int count() const { return split_.common_count + split_.a_count + split_.b_count; }
  const MovingPoint* points() {
    all_.assign(split_.common, split_.common + split_.common_count);
    all_.insert(all_.end(), split_.rest_a, split_.rest_a + split_.a_count);
    all_.insert(all_.end(), split_.rest_b, split_.rest_b + split_.b_count);
    return all_.data();
  }

  SharedVertices shared_;
  SharedSplit split_;
  std::vector<MovingPoint> all_;
  ExactMotion motion_;
  int a_[3], b_[3];
};

// Inserts a time into an ascending list, unless it is there.
void insertTime(RealRoot time, std::vector<RealRoot>& times) {
  auto place = times.end();
  while (place != times.begin()) {
    const int order = RealRoot::compare(time, *(place - 1));
    if (order == 0) return;
    if (order > 0) break;
    --place;
  }
  times.insert(place, std::move(time));
}

// A list of times that begins with 0 and 1.
class TimeList {
 public:
  TimeList() : times_{RealRoot(Dyadic{0, 0}), RealRoot(Dyadic{1, 0})} {}
  void addRoots(const Polynomial& f) {
    for (RealRoot& root : rootsInUnitInterval(f)) insertTime(std::move(root), times_);
  }
  std::vector<RealRoot> take() { return std::move(times_); }

 private:
  std::vector<RealRoot> times_;
};

// Returns, ascending, all times at which the sign of some orientation or comparison of the points
// changes. Between two of them the answer stays the same.
std::vector<RealRoot> timesOfChange(const ExactMotion& motion) {
  TimeList times;
  const int n = motion.count();
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      for (int axis = 0; axis < 3; ++axis) times.addRoots(motion.difference(i, j, axis));
      for (int k = j + 1; k < n; ++k) {
        for (int axis = 0; axis < 3; ++axis) times.addRoots(motion.orientation(i, j, k, axis));
        for (int l = k + 1; l < n; ++l) times.addRoots(motion.orientation3(i, j, k, l));
      }
    }
  }
  return times.take();
}

// Does the same for five points with fewer times, if no four of them always lie in one plane.
// Otherwise it returns an empty list. Two triangles with a common vertex meet beyond it iff an edge
// opposite to it meets the other triangle. While no four points lie in one plane, the signs of the
// five determinants decide that, and do not change.
std::vector<RealRoot> timesInOnePlane(const ExactMotion& motion) {
  TimeList times;
  for (int left_out = 0; left_out < 5; ++left_out) {
    int point[4];
    for (int i = 0; i < 4; ++i) point[i] = i < left_out ? i : i + 1;
    const Polynomial f = motion.orientation3(point[0], point[1], point[2], point[3]);
    if (f.isZero()) return {};
    times.addRoots(f);
  }
  return times.take();
}

}  // namespace

FirstTime exactFeatureTime(const Feature& feature, bool wants_time) {
  const ExactMotion motion(feature.x, 4);
  FirstTime first;
  const Polynomial coplanarity = motion.orientation3(0, 1, 2, 3);
  if (!coplanarity.isZero()) {
    addRoots(motion, coplanarity, wants_time, first,
             [&feature](const Instant& instant) { return meetsAt(feature.kind, instant); });
  } else if (feature.kind == FeatureKind::kVertexFace) {
    for (int i = 0; i < 3; ++i) addVertexOnEdge(motion, 3, i, (i + 1) % 3, wants_time, first);
  } else {
    addVertexOnEdge(motion, 0, 2, 3, wants_time, first);
    addVertexOnEdge(motion, 1, 2, 3, wants_time, first);
    addVertexOnEdge(motion, 2, 0, 1, wants_time, first);
    addVertexOnEdge(motion, 3, 0, 1, wants_time, first);
  }
  return first;
}

FirstTime exactTimeBeyondShared(const MovingTriangle& a, const MovingTriangle& b,
                                const SharedVertices& shared) {
  const SharingPair pair(a, b, shared);
  FirstTime first;
  if (pair.split().a_count == 0 || pair.split().b_count == 0) return first;
  if (pair.split().common_count == 2) {
    // Beyond a common edge they can meet only when all four points lie in one plane.
    const Polynomial coplanarity = pair.motion().orientation3(0, 1, 2, 3);
    if (!coplanarity.isZero()) {
      for (RealRoot& root : rootsInUnitInterval(coplanarity)) {
        if (pair.meetAt(root)) addTime(root, first);
      }
      return first;
    }
  }
  std::vector<RealRoot> times;
  if (pair.motion().count() == 5) times = timesInOnePlane(pair.motion());
  if (times.empty()) times = timesOfChange(pair.motion());
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (pair.meetAt(times[i])) {
      addTime(times[i], first);
      return first;
    }
    if (i + 1 == times.size()) return first;
    RealRoot between(RealRoot::numberBetween(times[i], times[i + 1]));
    if (pair.meetAt(between)) {  // right after times[i]
      first.low = times[i].floatLow();
      first.high = least(1.0F, most(times[i].floatHigh(), first.low + 0x1p-24F));
      return first;
    }
  }
  return first;
}

SweptVerdict decideOpen(const MovingTriangle& a, const MovingTriangle& b,
                        const SharedVertices& shared, bool wants_time, const SweptVerdict& quick,
                        PredicateState& state) {
  FirstTime first{quick.first_low, quick.first_high};
  if (quick.open == kWholePair) {
    ++state.exact;
    first = exactTimeBeyondShared(a, b, shared);
  } else {
    for (int i = 0; i < kFeatures; ++i) {
      if ((quick.open >> i & 1) == 0) continue;
      if (!wants_time && first.happens()) break;
      ++state.exact;
      const FirstTime time = exactFeatureTime(featureOf(a, b, i), wants_time);
      first.low = least(first.low, time.low);
      first.high = least(first.high, time.high);
    }
  }
  if (!first.happens() && quick.meets_at_end) first = {1, 1};
  SweptVerdict verdict;
  if (!first.happens()) return verdict;
  verdict.part = PartVerdict::kMeet;
  verdict.first_low = first.low;
  verdict.first_high = first.high;
  return verdict;
}

}  // namespace deformable_contact_monitor
