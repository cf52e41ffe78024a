#include "cuda/memory/reserved_memory.h"

#include <algorithm>
#include <iterator>

namespace deformable_contact_monitor {

ReservedMemory::ReservedMemory(void* memory, std::size_t bytes) {
  free_.emplace(static_cast<char*>(memory), bytes / kAlignment * kAlignment);
}

void* ReservedMemory::take(std::size_t bytes) {
  bytes = std::max<std::size_t>(1, (bytes + kAlignment - 1) / kAlignment) * kAlignment;
  const auto found = std::find_if(free_.begin(), free_.end(),
                                  [bytes](const auto& piece) { return piece.second >= bytes; });
  if (found == free_.end()) return nullptr;
  const auto [begin, size] = *found;
  free_.erase(found);
  if (size > bytes) free_.emplace(begin + bytes, size - bytes);
  taken_.emplace(begin, bytes);
  return begin;
}

bool ReservedMemory::giveBack(void* piece) {
  const auto found = taken_.find(static_cast<char*>(piece));
  if (found == taken_.end()) return false;
  char* begin = found->first;
  std::size_t bytes = found->second;
  taken_.erase(found);
  const auto next = free_.lower_bound(begin);
  if (next != free_.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == begin) {
      begin = before->first;
      bytes += before->second;
      free_.erase(before);
    }
  }
  if (next != free_.end() && begin + bytes == next->first) {
    bytes += next->second;
    free_.erase(next);
  }
  free_.emplace(begin, bytes);
  return true;
}

}  // namespace deformable_contact_monitor
