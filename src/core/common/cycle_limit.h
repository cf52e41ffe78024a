// The deadline and stop flag of a cycle, polled by every stage, and work that gives up when they
// are reached.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/export.h"
#include "core/limits.h"

namespace deformable_contact_monitor {

// The limits of one cycle. Once over() has returned true it always does, and its callers leave work
// undone. Any number of threads may call it.
class CycleLimit {
 public:
  explicit CycleLimit(const Limits& limits) : limits_(limits), set_(limits.any()) {}
  CycleLimit(const CycleLimit&) = delete;
  CycleLimit& operator=(const CycleLimit&) = delete;

  bool isSet() const { return set_; }

  // Returns whether the cycle must end. Call it about once per millisecond of work: it takes about
  // 50 ns if a limit is set, and next to nothing otherwise.
  bool over() const { return set_ && (wasOver() || look()); }

  // Returns whether over() has returned true to some caller. Otherwise no work was left undone.
  bool wasOver() const { return why_.load(std::memory_order_relaxed) != nullptr; }

  // Returns the reason, kNoTime or "stopped"; null unless wasOver().
  const char* why() const { return why_.load(std::memory_order_relaxed); }

 private:
  DCM_EXPORT bool look() const;

  Limits limits_;
  bool set_;
  mutable std::atomic<const char*> why_{nullptr};
};

// How many contacts a backend still sorts and lists once the limit is over. That takes about 20 ms.
constexpr std::uint32_t kMostListedLate = 1 << 18;

// Returns a limit that is never over.
const CycleLimit& noLimit();

// Polls a limit in loops of short steps, once in `steps` of them. For one thread.
class PacedLimit {
 public:
  PacedLimit(const CycleLimit& limit, std::uint64_t steps) : limit_(limit), steps_(steps) {}

  // Call it after `steps` more steps. Returns whether the loop must end.
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

// Resizes a list whose elements are about to be overwritten, so their values are unspecified. New
// memory is touched in steps, because the operating system provides it page by page. Gives up if
// the limit is over; the list is shorter then.
template <class List>
void resizeWithin(const CycleLimit& limit, std::size_t size, List& to) {
  constexpr std::size_t kStep = (std::size_t{1} << 20) / sizeof(typename List::value_type) + 1;
  if (to.capacity() < size) {
    to.clear();
    to.reserve(size + size / 8);  // so a scene that grows slowly does not allocate in each cycle
  }
  if (to.size() > size) to.resize(size);
  while (to.size() < size && !limit.over()) to.resize(std::min(size, to.size() + kStep));
}

// Calls sort(less), which sorts `size` elements with std::sort or selects with std::nth_element.
// Gives up if the limit is over; order and values of the elements are unspecified then. Elements
// must be plain data.
//
// The comparator throws to leave the algorithm. The standard allows that, and no other way out
// exists: a comparator that changes its answers is undefined behaviour. Sorting in blocks and
// merging them needs a second list, and the last merges of millions of elements take as long as a
// deadline; a selection cannot be split like that at all. Without a limit, and for short lists,
// nothing is added to the algorithm.
template <class Less, class Sort>
void sortWithin(const CycleLimit& limit, std::size_t size, const Less& less, const Sort& sort) {
  constexpr std::size_t kSoonSorted = 1 << 14;
  if (!limit.isSet() || size <= kSoonSorted) {
    sort(less);
    return;
  }
  struct GivenUp {};
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
