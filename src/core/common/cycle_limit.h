// Whether a cycle is to end early: what every stage asks, again and again.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/export.h"
#include "core/limits.h"

namespace deformable_contact_monitor {

// Of one cycle. Once it was seen to be over it stays so, and whoever saw it leaves work undone.
// Any number of threads may ask.
class CycleLimit {
 public:
  explicit CycleLimit(const Limits& limits) : limits_(limits), set_(limits.any()) {}
  CycleLimit(const CycleLimit&) = delete;
  CycleLimit& operator=(const CycleLimit&) = delete;

  bool isSet() const { return set_; }

  // To be asked about once in a millisecond of work; it takes some 50 ns where a limit is set.
  bool over() const { return set_ && (wasOver() || look()); }

  // Whether over() has said so to somebody: only then some work may have been left undone.
  bool wasOver() const { return why_.load(std::memory_order_relaxed) != nullptr; }

  // kNoTime, "stopped"; null unless wasOver().
  const char* why() const { return why_.load(std::memory_order_relaxed); }

 private:
  DCM_EXPORT bool look() const;

  Limits limits_;
  bool set_;
  mutable std::atomic<const char*> why_{nullptr};
};

// So many contacts a backend still sorts and lists once the limit is over: that takes some 20 ms.
constexpr std::uint32_t kMostListedLate = 1 << 18;

// One that is never over.
const CycleLimit& noLimit();

// For loops of short steps: asks the limit once in so many of them. One thread's.
class PacedLimit {
 public:
  PacedLimit(const CycleLimit& limit, std::uint64_t steps) : limit_(limit), steps_(steps) {}

  // To be asked after so many more steps.
  bool over(std::uint64_t steps = 1) {
    if (!limit_.isSet() || over_) return over_;
    done_ += steps;
    if (done_ < steps_) return false;
    done_ = 0;
    over_ = limit_.over();
    return over_;
  }

 private:
  const CycleLimit& limit_;
  std::uint64_t steps_, done_ = 0;
  bool over_ = false;
};

// As to.resize(size), of elements that are about to be written, whatever they were; memory that is
// new comes page by page. Gives up where the limit is over.
template <class List>
void resizeWithin(const CycleLimit& limit, std::size_t size, List& to) {
  constexpr std::size_t kStep = (std::size_t{1} << 20) / sizeof(typename List::value_type) + 1;
  if (to.capacity() < size) {
    to.clear();
    to.reserve(size + size / 8);  // a scene that grows a little does not allocate each time
  }
  if (to.size() > size) to.resize(size);
  while (to.size() < size && !limit.over()) to.resize(std::min(size, to.size() + kStep));
}

// Calls sort(less), which sorts `size` elements by std::sort or the like; gives up where the limit
// is over, and leaves any order and values then. Elements must be plain data.
template <class Less, class Sort>
void sortWithin(const CycleLimit& limit, std::size_t size, const Less& less, const Sort& sort) {
  constexpr std::size_t kSoonSorted = 1 << 14;
  if (!limit.isSet() || size <= kSoonSorted) {
    sort(less);
    return;
  }
  struct GivenUp {};  // there is no other way out of std::sort
  PacedLimit pace(limit, 1 << 16);
  try {
    sort([&less, &pace](const auto& a, const auto& b) {
      if (pace.over()) throw GivenUp();
      return less(a, b);
    });
  } catch (const GivenUp&) {  // NOLINT(bugprone-empty-catch)
  }
}

}  // namespace deformable_contact_monitor
