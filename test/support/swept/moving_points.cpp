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
  behind_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      for (int axis = 0; axis < 3; ++axis) {
        const Coordinate &p = coordinates_[i][axis], &q = coordinates_[j][axis];
        if (p.start < q.start && p.end < q.end) behind_[i][axis] |= only(static_cast<int>(j));
      }
    }
  }
}

std::vector<Event>& MovingPoints::volumes(PointSet points) {
  const auto found = volumes_.find(points);
  if (found != volumes_.end()) return found->second;
  return volumes_.emplace(points, volumesOf(pointsOf(points))).first->second;
}

std::vector<Event> MovingPoints::volumesOf(const std::vector<int>& p) {
  std::vector<Event> out;
  if (p.size() == 1) {
    out.emplace_back(IntegerPolynomial({mpz_class(1)}));
  } else if (p.size() == 2) {
    for (int axis = 0; axis < 3; ++axis) {
      const Coordinate &from = coordinates_[p[0]][axis], &to = coordinates_[p[1]][axis];
      const mpz_class at_start = to.start - from.start, at_end = to.end - from.end;
      out.emplace_back(IntegerPolynomial({at_start, at_end - at_start}));
    }
  } else if (p.size() == 3) {
    const std::vector<Event>& d = volumes(only(p[0]) | only(p[1]));
    const std::vector<Event>& e = volumes(only(p[0]) | only(p[2]));
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      out.emplace_back(d[u].polynomial() * e[v].polynomial() -
                       d[v].polynomial() * e[u].polynomial());
    }
  } else if (p.size() == 4) {
    const std::vector<Event>& d = volumes(only(p[0]) | only(p[1]));
    const std::vector<Event>& area = volumes(only(p[0]) | only(p[2]) | only(p[3]));
    out.emplace_back(d[0].polynomial() * area[0].polynomial() +
                     d[1].polynomial() * area[1].polynomial() +
                     d[2].polynomial() * area[2].polynomial());
  }
  return out;
}

bool MovingPoints::areApart(PointSet a, PointSet b) const {
  const auto areBefore = [this](PointSet first, PointSet second, int axis) {
    for (std::size_t i = 0; i < coordinates_.size(); ++i) {
      const bool is_first = (first & only(static_cast<int>(i))) != 0;
      if (is_first && (second & ~behind_[i][axis]) != 0) return false;
    }
    return true;
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (areBefore(a, b, axis) || areBefore(b, a, axis)) return true;
  }
  return false;
}

}  // namespace deformable_contact_monitor
