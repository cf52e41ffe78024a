#include "cuda/memory/pinned_memory.cuh"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <list>
#include <mutex>
#include <set>

#include "cuda/device/cuda_error.h"
#include "cuda/memory/pinned_pages.cuh"
#include "cuda/memory/reserved_memory.h"

namespace deformable_contact_monitor {
namespace {

// For as many as a scene of some 100 000 triangles needs in a process.
constexpr std::size_t kReservedBytes = std::size_t{16} << 20;

// Page-locked pages that are handed out in pieces, aligned to more than any type needs.
struct Chunk {
  explicit Chunk(std::size_t bytes) : pages(bytes), pieces(pages.data(), pages.bytes()) {}

  PinnedPages pages;
  ReservedMemory pieces;
};

class PinnedMemory : public std::pmr::memory_resource {
 public:
  PinnedMemory() {
    try {
      chunks_.emplace_back(kReservedBytes);
    } catch (const CudaError&) {  // it does without
    }
  }

 private:
  void* do_allocate(std::size_t bytes, std::size_t) override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      for (Chunk& chunk : chunks_) {
        if (void* const piece = chunk.pieces.take(bytes)) return piece;
      }
    }
    std::list<Chunk> more;  // not under the lock, for it takes long
    more.emplace_back(bytes);
    void* const piece = more.back().pieces.take(bytes);
    const std::lock_guard<std::mutex> lock(mutex_);
    chunks_.splice(chunks_.end(), more);
    return piece;
  }
  void do_deallocate(void* memory, std::size_t, std::size_t) override {
    std::list<Chunk> gone;  // nor this
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto its = std::find_if(chunks_.begin(), chunks_.end(),
                                  [memory](Chunk& chunk) { return chunk.pieces.giveBack(memory); });
    if (its->pieces.isWhole()) dropOthersThatAreWhole(its, gone);
  }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
    return this == &other;
  }
  // The first one stays, and so does this: what grows soon has another place again.
  void dropOthersThatAreWhole(std::list<Chunk>::iterator kept, std::list<Chunk>& gone) {
    for (auto chunk = std::next(chunks_.begin()); chunk != chunks_.end();) {
      const auto next = std::next(chunk);
      if (chunk != kept && chunk->pieces.isWhole()) gone.splice(gone.end(), chunks_, chunk);
      chunk = next;
    }
  }

  std::mutex mutex_;
  std::list<Chunk> chunks_;
};

class PinnedOrPlainMemory : public std::pmr::memory_resource {
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    try {
      return pinnedMemory().allocate(bytes, alignment);
    } catch (const CudaError&) {
      void* const memory = plain_.allocate(bytes, alignment);
      const std::lock_guard<std::mutex> lock(mutex_);
      in_plain_.insert(memory);
      return memory;
    }
  }
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
    if (isPlain(memory)) {
      plain_.deallocate(memory, bytes, alignment);
    } else {
      pinnedMemory().deallocate(memory, bytes, alignment);
    }
  }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
    return this == &other;
  }
  bool isPlain(void* memory) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return in_plain_.erase(memory) > 0;
  }

  std::pmr::memory_resource& plain_ = *std::pmr::new_delete_resource();
  std::mutex mutex_;
  std::set<void*> in_plain_;
};

}  // namespace

std::pmr::memory_resource& pinnedMemory() {
  static auto* const memory = new PinnedMemory;  // lists may end after static objects do
  return *memory;
}

std::pmr::memory_resource& pinnedOrPlainMemory() {
  static auto* const memory = new PinnedOrPlainMemory;
  return *memory;
}

}  // namespace deformable_contact_monitor
