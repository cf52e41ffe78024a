// Arrays on the host that may lie in memory of a backend's choice.
#pragma once

#include <memory_resource>
#include <new>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {

// A vector whose memory a backend may lend, so that its device reads or writes it without a copy in
// between. Copies are in plain memory, as a std::vector of their own if one likes.
template <class T>
class HostList : public std::pmr::vector<T> {
 public:
  using Vector = std::pmr::vector<T>;
  using Vector::Vector;
  using Vector::operator=;

  HostList() = default;
  HostList(const HostList&) = default;
  HostList(HostList&&) = default;  // NOLINT(performance-noexcept-*): the vector's say
  HostList& operator=(const HostList&) = default;
  HostList& operator=(HostList&&) = default;  // NOLINT(performance-noexcept-*): the same
  ~HostList() = default;
  HostList(const std::vector<T>& list) : Vector(list.begin(), list.end()) {}  // NOLINT(google-*)
  operator std::vector<T>() const { return {this->begin(), this->end()}; }    // NOLINT(google-*)

  // From now on it lies there; `memory` outlives it.
  void moveTo(std::pmr::memory_resource& memory) {
    HostList moved(*this, &memory);
    this->~HostList();
    new (this) HostList(std::move(moved));
  }

  // After this no memory is taken as it becomes that one by a move, wherever both lie. As it grows
  // it gets some to spare, for a backend's memory takes its time to come.
  void makeRoomFor(const HostList& list) {
    const bool is_copied = this->get_allocator() != list.get_allocator();
    if (is_copied && list.size() > this->capacity()) this->reserve(list.size() + list.size() / 4);
  }

  friend bool operator==(const HostList& a, const HostList& b) {
    return static_cast<const Vector&>(a) == static_cast<const Vector&>(b);
  }
  friend bool operator!=(const HostList& a, const HostList& b) { return !(a == b); }
};

}  // namespace deformable_contact_monitor
