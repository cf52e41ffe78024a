// When two convex hulls of moving points first meet: by minimal Radon partitions.
#include "moving_hulls.h"

#include <algorithm>
#include <utility>

namespace deformable_contact_monitor {
namespace {

// Disjoint, none empty, five points at most in all.
struct Circuit {
  PointSet positive, negative;

  PointSet points() const { return positive | negative; }
};

// Returns whether the points are a circuit with these signs at time t.
bool isCircuitAt(AlgebraicTime& t, const Circuit& circuit, MovingPoints& points) {
  const PointSet all = circuit.points();
  for (const Event& volume : points.volumes(all)) {
    if (t.signOf(volume.polynomial()) != 0) return false;
  }
  // The dependency's coefficients, by Cramer's rule, in the first projection in which not all of
  // them are 0: there it is a bijection of what the points span.
  const std::vector<int> members = pointsOf(all);
  const std::size_t projections = points.volumes(all & ~only(members[0])).size();
  for (std::size_t projection = 0; projection < projections; ++projection) {
    int with_sign = 0, against = 0, zeros = 0;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const Event& rest = points.volumes(all & ~only(members[i]))[projection];
      int sign = t.signOf(rest.polynomial());
      if (i % 2 == 1) sign = -sign;
      if ((circuit.negative & only(members[i])) != 0) sign = -sign;
      with_sign += sign > 0;
      against += sign < 0;
      zeros += sign == 0;
    }
    if (zeros == static_cast<int>(members.size())) continue;
    return zeros == 0 && (with_sign == 0 || against == 0);
  }
  return false;
}

// Returns whether the common point of a circuit's two sides lies in the convex hull of the shared
// points at t. Each side must have a point that is not shared.
bool isSharedPointAt(AlgebraicTime& t, const Circuit& circuit, PointSet shared,
                     MovingPoints& points) {
  if (sizeOf(shared) == 1) {
    // A shared point of the circuit is a corner of one side, whose inside has the common point.
    return (circuit.points() & shared) == 0 && isCircuitAt(t, {circuit.positive, shared}, points) &&
           isCircuitAt(t, {shared, circuit.negative}, points);
  }
  // Two shared, and one more each. Two segments that cross, one from each shared point: not on the
  // line of these. Else one side is a point, which may be on the segment between the shared ones.
  const std::vector<int> ends = pointsOf(shared);
  for (const PointSet side : {circuit.positive, circuit.negative}) {
    if (sizeOf(side) != 1) continue;
    return isCircuitAt(t, {side, only(ends[0])}, points) ||
           isCircuitAt(t, {side, only(ends[1])}, points) || isCircuitAt(t, {side, shared}, points);
  }
  return false;
}

// A time to look at, which stands for itself or for all between two events.
struct Moment {
  AlgebraicTime time;
  AlgebraicTime begin;  // of what it stands for
  bool is_event;
};

// All roots of the polynomials, the step's ends, and a time between each two of them.
std::vector<Moment> eventsAndBetween(const std::vector<Event*>& events) {
  std::vector<AlgebraicTime> times{AlgebraicTime({0, 0}), AlgebraicTime({1, 0})};
  for (Event* event : events) {
    if (event->isAlways()) continue;
    times.insert(times.end(), event->roots().begin(), event->roots().end());
  }
  std::vector<AlgebraicTime> ordered;
  for (AlgebraicTime& time : times) {
    auto place = ordered.begin();
    int order = -1;
    while (place != ordered.end() && (order = compare(*place, time)) < 0) ++place;
    if (place == ordered.end() || order > 0) ordered.insert(place, time);
  }
  std::vector<Moment> moments;
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    moments.push_back({ordered[i], ordered[i], true});
    if (i + 1 == ordered.size()) break;
    const DyadicRational middle = between(ordered[i], ordered[i + 1]);
    moments.push_back({AlgebraicTime(middle), ordered[i], false});
  }
  return moments;
}

void append(std::vector<Event>& from, std::vector<Event*>* to) {
  for (Event& event : from) to->push_back(&event);
}

// Where the answer for a circuit can change, in order.
std::vector<Moment> momentsOf(const Circuit& circuit, PointSet shared, MovingPoints& points) {
  const PointSet all = circuit.points();
  // Equations: what is not always 0 leaves its roots alone.
  for (Event& volume : points.volumes(all)) {
    if (volume.isAlways()) continue;
    std::vector<Moment> moments;
    for (const AlgebraicTime& root : volume.roots()) moments.push_back({root, root, true});
    return moments;
  }
  std::vector<Event*> events;
  for (const int i : pointsOf(all)) append(points.volumes(all & ~only(i)), &events);
  if ((all | shared) != all || sizeOf(shared) > 1) {
    for (PointSet set = 1; set <= points.all(); ++set) {
      if ((set & ~(all | shared)) == 0 && sizeOf(set) <= 4) append(points.volumes(set), &events);
    }
  }
  return eventsAndBetween(events);
}

std::optional<MeetingTime> firstTimeOf(const Circuit& circuit, PointSet shared,
                                       MovingPoints& points) {
  for (Moment& moment : momentsOf(circuit, shared, points)) {
    if (isCircuitAt(moment.time, circuit, points) &&
        (shared == 0 || !isSharedPointAt(moment.time, circuit, shared, points))) {
      return MeetingTime{moment.begin, moment.is_event};
    }
  }
  return std::nullopt;
}

// Calls visit(circuit) for each that may show a common point beyond the shared ones, until it says
// true.
template <typename Visit>
void forEachCircuit(const MovingHulls& hulls, const MovingPoints& points, const Visit& visit) {
  const PointSet shared = hulls.a & hulls.b;
  for (PointSet positive = 1; positive <= hulls.a; ++positive) {
    for (PointSet negative = 1; negative <= hulls.b; ++negative) {
      const bool are_parts =
          (positive & ~hulls.a) == 0 && (negative & ~hulls.b) == 0 && (positive & negative) == 0;
      if (!are_parts || sizeOf(positive | negative) > 5) continue;
      // A side of shared points alone has its hull in theirs.
      if ((positive & ~shared) == 0 || (negative & ~shared) == 0) continue;
      if (!points.areApart(positive, negative) && visit(Circuit{positive, negative})) return;
    }
  }
}

}  // namespace

std::optional<MeetingTime> firstMeeting(const MovingHulls& hulls) {
  MovingPoints points(hulls.points);
  std::optional<MeetingTime> first;
  forEachCircuit(hulls, points, [&](const Circuit& circuit) {
    std::optional<MeetingTime> found = firstTimeOf(circuit, hulls.a & hulls.b, points);
    if (!found) return false;
    const int order = first ? compare(found->time, first->time) : -1;
    if (order < 0) first = found;
    if (order == 0) first->is_attained |= found->is_attained;
    return false;
  });
  return first;
}

bool meetEver(const MovingHulls& hulls) {
  MovingPoints points(hulls.points);
  bool meet = false;
  forEachCircuit(hulls, points, [&](const Circuit& circuit) {
    return meet = firstTimeOf(circuit, hulls.a & hulls.b, points).has_value();
  });
  return meet;
}

}  // namespace deformable_contact_monitor
