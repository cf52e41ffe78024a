// Memory that does not suffice.
#pragma once

#include <cstddef>

namespace deformable_contact_monitor {

// While there is one, `new` throws std::bad_alloc, on any thread, for more than so many bytes.
class LimitedMemory {
 public:
  explicit LimitedMemory(std::size_t most);
  ~LimitedMemory();
  LimitedMemory(const LimitedMemory&) = delete;
  LimitedMemory& operator=(const LimitedMemory&) = delete;
};

}  // namespace deformable_contact_monitor
