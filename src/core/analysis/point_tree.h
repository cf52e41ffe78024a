// Stores points in a tree, for many queries of the points within a box.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "core/predicates/aabb.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// A balanced k-d tree that halves the points along x, y and z in turn. It only compares
// coordinates, so equal, distant and clustered points cost no more than others. With n points a
// query takes about n^(2/3) steps at most, and one more for each point found. Any number of threads
// may query.
class PointTree {
 public:
  // Takes finite points.
  explicit PointTree(std::vector<Vec3f> points) : points_(std::move(points)) {
    order_.resize(points_.size());
    std::iota(order_.begin(), order_.end(), 0U);
    halve(0, order_.size(), 0);
  }

  // Calls visit(index) for each point within the closed box, in any order.
  template <class Visit>
  void visitWithin(const Aabb& box, const Visit& visit) const {
    look(0, order_.size(), 0, box, visit);
  }

 private:
  // Orders the points of [begin, end): the middle one is the median along the axis, points before
  // it are not greater there, and points after it not less.
  void halve(std::size_t begin, std::size_t end, int axis) {
    if (end - begin < 2) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [this](std::size_t i) {
      return order_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    std::nth_element(at(begin), at(middle), at(end),
                     [this, axis](std::uint32_t i, std::uint32_t j) {
                       return points_[i][axis] < points_[j][axis];
                     });
    halve(begin, middle, (axis + 1) % 3);
    halve(middle + 1, end, (axis + 1) % 3);
  }

  template <class Visit>
  void look(std::size_t begin, std::size_t end, int axis, const Aabb& box,
            const Visit& visit) const {
    if (begin == end) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const Vec3f& point = points_[order_[middle]];
    if (box.min[axis] <= point[axis]) look(begin, middle, (axis + 1) % 3, box, visit);
    if (intersects(box, {point, point})) visit(order_[middle]);
    if (point[axis] <= box.max[axis]) look(middle + 1, end, (axis + 1) % 3, box, visit);
  }

  std::vector<Vec3f> points_;
  std::vector<std::uint32_t> order_;
};

}  // namespace deformable_contact_monitor
