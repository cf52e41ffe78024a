// Keeps disjoint sets of numbered items (union-find).
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace deformable_contact_monitor {

// Owns disjoint sets of the items 0, 1, ... Each item starts in a set of its own. A set is a tree
// whose root is its least item, so results do not depend on the order of joins. One thread at a
// time.
class UnionFind {
 public:
  explicit UnionFind(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  // Adds an item in a set of its own. Returns its number.
  std::uint32_t add() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    return parent_.back();
  }

  // Returns the least item of the set of i. Shortens paths on the way.
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  // Joins the sets of i and j.
  void join(std::uint32_t i, std::uint32_t j) {
    i = find(i);
    j = find(j);
    (i < j ? parent_[j] : parent_[i]) = i < j ? i : j;
  }

  std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::uint32_t> parent_;  // per item; never greater than the item itself
};

}  // namespace deformable_contact_monitor
