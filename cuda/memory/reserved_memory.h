// Hands out pieces of one block of memory.
#pragma once

#include <cstddef>
#include <map>

namespace deformable_contact_monitor {

// Manages any kind of memory, for it never reads or writes it. For one thread at a time.
class ReservedMemory {
 public:
  // Alignment of the pieces, of those that memory begins at included.
  static constexpr std::size_t kAlignment = 256;

  ReservedMemory() = default;  // none
  ReservedMemory(void* memory, std::size_t bytes);

  // The first place that has room; null if none does.
  void* take(std::size_t bytes);

  // Takes a piece back. Returns false if it is not one of this block.
  bool giveBack(void* piece);

  // Returns whether no piece is in use.
  bool isWhole() const { return taken_.empty(); }

 private:
  using Pieces = std::map<char*, std::size_t>;  // where they begin, and their bytes

  Pieces free_;  // none touches another
  Pieces taken_;
};

}  // namespace deformable_contact_monitor
