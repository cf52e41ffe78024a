// The clusters' prototypes, ready to be searched.
#pragma once

#include <vector>

#include "core/half_space_rule.h"

namespace deformable_contact_monitor {

class Prototypes {
 public:
  // Takes prototypes in scaled coordinates; of those that coincide, one is kept. At least one.
  void build(const std::vector<Vec3f>& prototypes);

  PrototypesView view() const {
    return {points_.data(), neighbours_.data(), static_cast<std::uint32_t>(points_.size()),
            neighbour_count_};
  }
  std::size_t size() const { return points_.size(); }

 private:
  std::vector<Vec3f> points_;
  std::vector<Neighbour> neighbours_;
  std::uint32_t neighbour_count_ = 0;
};

}  // namespace deformable_contact_monitor
