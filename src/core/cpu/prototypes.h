// The clusters' prototypes, ready to be searched.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/rules/half_space.h"

namespace deformable_contact_monitor {

class Prototypes {
 public:
  // Takes prototypes in scaled coordinates; of those that coincide, one is kept. At least one.
  // Where the limit was over, they are of no use.
  void build(const std::vector<Vec3f>& prototypes, const CycleLimit& limit = noLimit());

  PrototypesView view() const {
    return {points_.data(), list_reach_.data(), neighbours_.data(), neighbour_cluster_.data(),
            static_cast<std::uint32_t>(points_.size())};
  }
  std::size_t size() const { return points_.size(); }

 private:
  void listNeighbours(std::size_t g, std::vector<std::pair<float, std::uint32_t>>& others);

  std::vector<Vec3f> points_;
  std::vector<float> list_reach_;
  std::vector<Neighbour> neighbours_;
  std::vector<std::uint32_t> neighbour_cluster_;
};

}  // namespace deformable_contact_monitor
