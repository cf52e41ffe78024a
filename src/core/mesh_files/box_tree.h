// A tree of boxes in the plane, over items in the order of a polygon's corners. Neighbours in that
// order are mostly near each other, so the tree is built without sorting.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/predicates/orientation.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Points of the plane have z = 0. Returns 1 if a, b, c turn left, -1 if they turn right, and 0 if
// they are on one line. The answer is exact for all finite coordinates.
inline int turn(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  PredicateState state;
  return orient2d(a, b, c, 2, state);
}

// A rectangle in the plane, with its sides along the axes. It holds nothing until add() is called.
struct PlaneBox {
  float low[2] = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
  float high[2] = {-std::numeric_limits<float>::infinity(),
                   -std::numeric_limits<float>::infinity()};

  void add(const Vec3f& p) {
    low[0] = std::min(low[0], p.x);
    low[1] = std::min(low[1], p.y);
    high[0] = std::max(high[0], p.x);
    high[1] = std::max(high[1], p.y);
  }
  void add(const PlaneBox& box) {
    for (int axis = 0; axis < 2; ++axis) {
      low[axis] = std::min(low[axis], box.low[axis]);
      high[axis] = std::max(high[axis], box.high[axis]);
    }
  }
  bool meets(const PlaneBox& other) const {
    return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] &&
           other.low[1] <= high[1];
  }
};

// A closed triangle in the plane whose corners turn left. A segment has one corner twice.
class PlaneTriangle {
 public:
  PlaneTriangle(const Vec3f& a, const Vec3f& b, const Vec3f& c) : corner_{a, b, c} {
    for (const Vec3f& corner : corner_) box_.add(corner);
  }

  const Vec3f& corner(std::size_t i) const { return corner_[i]; }
  const PlaneBox& box() const { return box_; }

  // Returns false only if the triangle and the box are certainly apart: the box is to the right of
  // a side, or the triangle's own box is apart from it.
  bool mayMeet(const PlaneBox& box) const {
    if (!box_.meets(box)) return false;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3f &from = corner_[i], &to = corner_[(i + 1) % 3];
      const Vec3f leftmost{to.y > from.y ? box.low[0] : box.high[0],
                           to.x > from.x ? box.high[1] : box.low[1], 0};
      if (orient2dFiltered(from, to, leftmost, 2) == -1) return false;
    }
    return true;
  }

 private:
  std::array<Vec3f, 3> corner_;
  PlaneBox box_;
};

class PlaneBoxTree {
 public:
  // `work` is how many more boxes may be tested. It is shared by several trees and outlives them.
  PlaneBoxTree(const std::vector<PlaneBox>& items, std::uint64_t* work) : work_(work) {
    while (first_ < items.size()) first_ *= 2;
    boxes_.resize(2 * first_);
    std::copy(items.begin(), items.end(), boxes_.begin() + static_cast<std::ptrdiff_t>(first_));
    for (std::size_t node = first_ - 1; node > 0; --node) join(node);
  }

  // Replaces the box of an item. An empty box takes the item out.
  void set(std::size_t item, const PlaneBox& box) {
    std::size_t node = first_ + item;
    boxes_[node] = box;
    for (node /= 2; node > 0; node /= 2) join(node);
  }

  // Calls visit(item) for each item whose box may meet the triangle, until a call returns true.
  // Returns whether one did. Returns true, too, if there is no more work allowed.
  template <typename Visit>
  bool anyOf(const PlaneTriangle& triangle, const Visit& visit) const {
    std::size_t stack[64];
    std::size_t size = 0;
    stack[size++] = 1;
    while (size > 0) {
      const std::size_t node = stack[--size];
      if (*work_ == 0) return true;
      --*work_;
      if (!triangle.mayMeet(boxes_[node])) continue;
      if (node >= first_) {
        *work_ -= std::min(*work_, kVisitWork);
        if (visit(node - first_)) return true;
      } else {
        stack[size++] = 2 * node + 1;
        stack[size++] = 2 * node;
      }
    }
    return false;
  }

 private:
  // A visit of an item takes about as long as these tests of boxes.
  static constexpr std::uint64_t kVisitWork = 8;

  void join(std::size_t node) {
    boxes_[node] = boxes_[2 * node];
    boxes_[node].add(boxes_[2 * node + 1]);
  }

  // Node 1 is the root, and node n has the children 2 n and 2 n + 1. Item i is node first_ + i.
  std::vector<PlaneBox> boxes_;
  std::size_t first_ = 1;
  std::uint64_t* work_;
};

}  // namespace deformable_contact_monitor
