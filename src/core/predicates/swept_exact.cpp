#include "core/predicates/swept_exact.h"

#include <utility>
#include <vector>

#include "core/predicates/swept_instant.h"

namespace deformable_contact_monitor {
namespace {

void addTime(RealRoot& time, FirstTime& first) {
  first.low = least(first.low, time.floatLow());
  first.high = least(first.high, time.floatHigh());
}

// Adds the roots of f at which `happens` says yes; the first one found will do without a time.
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

// Two points that are not together at t = 0.
void addVertexOnVertex(const ExactMotion& motion, int p, int q, bool wants_time, FirstTime& first) {
  for (int axis = 0; axis < 3; ++axis) {
    const Polynomial apart = motion.difference(p, q, axis);
    if (apart.isZero()) continue;
    addRoots(motion, apart, wants_time, first,
             [p, q](const Instant& instant) { return at(instant, p) == at(instant, q); });
    return;
  }
}

// A point that is not on the segment ab at t = 0.
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
  // Always on one line.
  addVertexOnVertex(motion, p, a, wants_time, first);
  addVertexOnVertex(motion, p, b, wants_time, first);
}

bool meetsAt(FeatureKind kind, const Instant& instant) {
  PredicateState state;
  const PointAt x0 = at(instant, 0), x1 = at(instant, 1), x2 = at(instant, 2), x3 = at(instant, 3);
  if (kind == FeatureKind::kEdgeEdge) return segmentsIntersect(x0, x1, x2, x3, state);
  return segmentIntersectsTriangle(x3, x3, TriangleAt{{x0, x1, x2}}, state);
}

// Two triangles that share vertices, as indices into one motion.
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

// All times, ascending, at which the sign of some orientation or comparison of the points changes:
// between two of them nothing changes.
std::vector<RealRoot> timesOfChange(const ExactMotion& motion) {
  std::vector<RealRoot> times = {RealRoot(Dyadic{0, 0}), RealRoot(Dyadic{1, 0})};
  const auto add = [&times](const Polynomial& f) {
    for (RealRoot& root : rootsInUnitInterval(f)) insertTime(std::move(root), times);
  };
  const int n = motion.count();
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      for (int axis = 0; axis < 3; ++axis) add(motion.difference(i, j, axis));
      for (int k = j + 1; k < n; ++k) {
        for (int axis = 0; axis < 3; ++axis) add(motion.orientation(i, j, k, axis));
        for (int l = k + 1; l < n; ++l) add(motion.orientation3(i, j, k, l));
      }
    }
  }
  return times;
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
    // Beyond a common edge they meet only where all four points lie in one plane.
    const Polynomial coplanarity = pair.motion().orientation3(0, 1, 2, 3);
    if (!coplanarity.isZero()) {
      for (RealRoot& root : rootsInUnitInterval(coplanarity)) {
        if (pair.meetAt(root)) addTime(root, first);
      }
      return first;
    }
  }
  std::vector<RealRoot> times = timesOfChange(pair.motion());
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (pair.meetAt(times[i])) {
      addTime(times[i], first);
      return first;
    }
    if (i + 1 == times.size()) return first;
    RealRoot between(RealRoot::numberBetween(times[i], times[i + 1]));
    if (pair.meetAt(between)) {  // from right after times[i] on
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
