// From the host's memory to the device by a kernel, and what else a cycle begins with.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>

namespace deformable_contact_monitor {

// As many copies as a kernel takes as its argument.
struct HostCopyList {
  static constexpr unsigned kMost = 16;
  const std::uint32_t* from[kMost];  // null: zeros
  std::uint32_t* to[kMost];
  std::uint32_t words[kMost];
  std::uint32_t plus[kMost];         // to each word
  std::uint32_t first_block[kMost];  // of those that make it
  unsigned count = 0;
};

// Copies that one kernel makes, for a launch takes longer than most of them do. The driver's own
// copies run on an engine of their own, and kernels behind one may begin some 5 us later.
class HostCopies {
 public:
  explicit HostCopies(cudaStream_t stream) : stream_(stream) {}

  // `count` elements of whole words. `from`: the device's memory, or where it reaches page-locked
  // memory (reachedAt()), which may go once the stream has been waited for. Where there are many
  // copies, launches those ahead.
  template <class T>
  void add(const T* from, std::size_t count, T* to) {
    constexpr std::size_t kBytes = sizeof(T), kWordBytes = sizeof(std::uint32_t);
    static_assert(kBytes % kWordBytes == 0);
    addWords(reinterpret_cast<const std::uint32_t*>(from), count * (kBytes / kWordBytes),
             reinterpret_cast<std::uint32_t*>(to));
  }

  // The same of numbers, each of which becomes larger by `first`.
  template <class Index>
  void addNumbers(const std::uint32_t* from, std::size_t count, Index* to, std::uint32_t first) {
    static_assert(sizeof(Index) == sizeof(std::uint32_t));
    addWords(from, count, reinterpret_cast<std::uint32_t*>(to), first);
  }

  // `count` elements become zeros.
  template <class T>
  void addZeros(std::size_t count, T* to) {
    add(static_cast<const T*>(nullptr), count, to);
  }

  // What was added goes into the stream. What was not launched is not copied.
  void launch();
  // What was added and not launched is forgotten.
  void forget() { list_.count = blocks_ = 0; }

 private:
  void addWords(const std::uint32_t* from, std::size_t words, std::uint32_t* to,
                std::uint32_t plus = 0);

  cudaStream_t stream_;
  HostCopyList list_;
  std::uint32_t blocks_ = 0;
};

}  // namespace deformable_contact_monitor
