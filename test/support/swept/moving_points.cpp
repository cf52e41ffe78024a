// Up to six points that move on straight lines, and the determinants that say how they lie.
#include "moving_points.h"

#include <algorithm>

namespace deformable_contact_monitor {

bool operator==(const Trajectory& a, const Trajectory& b) {
  return a.start == b.start && a.end == b.end;
}

int sizeOf(PointSet set) { return static_cast<int>(pointsOf(set).size()); }

std::vector<int> pointsOf(PointSet set) {
  std::vector<int> points;
  for (int i = 0; set >> i != 0; ++i) {
    if ((set & only(i)) != 0) points.push_back(i);
  }
  return points;
}

const std::vector<AlgebraicTime>& Event::roots() {
  if (!roots_) roots_ = rootsInStep(polynomial_);
  return *roots_;
}

MovingPoints::MovingPoints(const std::vector<Trajectory>& points) {
  mpz_class scale = 1;
  for (const Trajectory& p : points) {
    for (int axis = 0; axis < 3; ++axis) {
      scale = lcm(scale, lcm(p.start[axis].get_den(), p.end[axis].get_den()));
    }
  }
  for (const Trajectory& p : points) {
    std::array<Coordinate, 3> scaled;
    for (int axis = 0; axis < 3; ++axis) {
      scaled[axis] = {p.start[axis].get_num() * (scale / p.start[axis].get_den()),
                      p.end[axis].get_num() * (scale / p.end[axis].get_den())};
    }
    coordinates_.push_back(scaled);
  }
}

IntegerPolynomial MovingPoints::difference(int from, int to, int axis) const {
  const Coordinate& a = coordinates_[from][axis];
  const Coordinate& b = coordinates_[to][axis];
  const mpz_class at_start = b.start - a.start, at_end = b.end - a.end;
  return IntegerPolynomial({at_start, at_end - at_start});
}

std::vector<Event> MovingPoints::volumesOf(const std::vector<int>& points) const {
  // d(i, axis): from the first point to another one.
  const auto d = [&](int i, int axis) { return difference(points[0], points[i], axis); };
  const auto area = [&](int i, int j, int axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    return d(i, u) * d(j, v) - d(i, v) * d(j, u);
  };
  std::vector<Event> out;
  if (points.size() == 1) out.emplace_back(IntegerPolynomial({mpz_class(1)}));
  for (int axis = 0; axis < 3; ++axis) {
    if (points.size() == 2) out.emplace_back(d(1, axis));
    if (points.size() == 3) out.emplace_back(area(1, 2, axis));
  }
  if (points.size() == 4) {
    out.emplace_back(d(1, 0) * area(2, 3, 0) + d(1, 1) * area(2, 3, 1) + d(1, 2) * area(2, 3, 2));
  }
  return out;
}

std::vector<Event>& MovingPoints::volumes(PointSet points) {
  const auto found = volumes_.find(points);
  if (found != volumes_.end()) return found->second;
  return volumes_.emplace(points, volumesOf(pointsOf(points))).first->second;
}

bool MovingPoints::boxesOverlap(PointSet a, PointSet b) const {
  for (int axis = 0; axis < 3; ++axis) {
    const auto range = [this, axis](PointSet set) {
      const mpz_class* least = nullptr;
      const mpz_class* most = nullptr;
      for (const int i : pointsOf(set)) {
        for (const mpz_class* x : {&coordinates_[i][axis].start, &coordinates_[i][axis].end}) {
          if (least == nullptr || *x < *least) least = x;
          if (most == nullptr || *x > *most) most = x;
        }
      }
      return std::make_pair(least, most);
    };
    const auto [low_a, high_a] = range(a);
    const auto [low_b, high_b] = range(b);
    if (*high_a < *low_b || *high_b < *low_a) return false;
  }
  return true;
}

}  // namespace deformable_contact_monitor
