// Which of a number of things hang together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace deformable_contact_monitor {

// Things 0, 1, ..., each alone at first. One thread at a time.
class UnionFind {
 public:
  explicit UnionFind(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  // One more, alone; its number.
  std::uint32_t add() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    return parent_.back();
  }

  // The least of those that hang together with i.
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  void join(std::uint32_t i, std::uint32_t j) {
    i = find(i);
    j = find(j);
    (i < j ? parent_[j] : parent_[i]) = i < j ? i : j;
  }

  std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::uint32_t> parent_;  // never greater than the thing itself
};

}  // namespace deformable_contact_monitor
