// One piece of memory that is there from the start, lent out in smaller ones.
#pragma once

#include <cstddef>
#include <map>

namespace deformable_contact_monitor {

// Of any memory: it does not look into it. One thread at a time.
class ReservedMemory {
 public:
  // Alignment of the pieces, of those that memory begins at included.
  static constexpr std::size_t kAlignment = 256;

  ReservedMemory() = default;  // none
  ReservedMemory(void* memory, std::size_t bytes);

  // The first place that has room; null if none does.
  void* take(std::size_t bytes);

  // Whether a piece is one of its own, which it then has back.
  bool giveBack(void* piece);

  // Whether no piece is lent.
  bool isWhole() const { return lent_.empty(); }

 private:
  using Pieces = std::map<char*, std::size_t>;  // where they begin, and their bytes

  Pieces free_;  // none touches another
  Pieces lent_;
};

}  // namespace deformable_contact_monitor
