// Copies from the host's memory to the device, and clears device memory, by one kernel.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>

namespace deformable_contact_monitor {

// The argument of the kernel: a list of copies, of kMost at most.
struct HostCopyList {
  static constexpr unsigned kMost = 16;
  const std::uint32_t* from[kMost];  // null: zeros
  std::uint32_t* to[kMost];
  std::uint32_t words[kMost];
  std::uint32_t plus[kMost];         // added to each word
  std::uint32_t first_block[kMost];  // the first block that makes the copy
  unsigned count = 0;
};

// Collects copies that one kernel makes, because a launch takes longer than most copies do. Copies
// by the driver run on an engine of their own, which can delay the next kernels by some 5 us.
class HostCopies {
 public:
  explicit HostCopies(cudaStream_t stream) : stream_(stream) {}

  // Adds a copy of `count` elements, whose size is a multiple of 4 bytes. `from` is device memory,
  // or the device's address of page-locked memory (reachedAt()), which must stay until the stream
  // has been waited for. If the list is full, its copies are launched first.
  template <class T>
  void add(const T* from, std::size_t count, T* to) {
    constexpr std::size_t kBytes = sizeof(T), kWordBytes = sizeof(std::uint32_t);
    static_assert(kBytes % kWordBytes == 0);
    addWords(reinterpret_cast<const std::uint32_t*>(from), count * (kBytes / kWordBytes),
             reinterpret_cast<std::uint32_t*>(to));
  }

  // Adds a copy of numbers, and adds `first` to each of them.
  template <class Index>
  void addNumbers(const std::uint32_t* from, std::size_t count, Index* to, std::uint32_t first) {
    static_assert(sizeof(Index) == sizeof(std::uint32_t));
    addWords(from, count, reinterpret_cast<std::uint32_t*>(to), first);
  }

  // Sets `count` elements to zero.
  template <class T>
  void addZeros(std::size_t count, T* to) {
    add(static_cast<const T*>(nullptr), count, to);
  }

  // Enqueues one kernel that makes the copies added so far.
  void launch();
  // Drops the copies that were added and not launched.
  void forget() { list_.count = blocks_ = 0; }

 private:
  void addWords(const std::uint32_t* from, std::size_t words, std::uint32_t* to,
                std::uint32_t plus = 0);

  cudaStream_t stream_;
  HostCopyList list_;
  std::uint32_t blocks_ = 0;
};

}  // namespace deformable_contact_monitor
