// One of several parts of an evaluation of bags.
#pragma once

#include <cstdint>

namespace deformable_contact_monitor {

// Parts 1 to `of` have each cycle once.
struct BagPart {
  std::uint64_t number = 1, of = 1;
};

}  // namespace deformable_contact_monitor
