#include "limited_memory.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t kAny = ~std::size_t{0};
std::atomic<std::size_t> most_at_once{kAny};

}  // namespace

void* operator new(std::size_t size) {
  void* memory = size <= most_at_once ? std::malloc(size) : nullptr;
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace deformable_contact_monitor {

LimitedMemory::LimitedMemory(std::size_t most) { most_at_once = most; }
LimitedMemory::~LimitedMemory() { most_at_once = kAny; }

}  // namespace deformable_contact_monitor
