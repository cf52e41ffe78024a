// Lists on the host whose memory a backend may provide.
#pragma once

#include <memory_resource>
#include <new>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {

// A std::pmr::vector whose memory a backend may provide, so that its device reads or writes the
// list without another copy. Copies use plain memory.
//
// It derives from the vector instead of being an alias for two reasons: it converts from and to
// std::vector, in which programs keep their meshes, and it can move to other memory. It adds no
// member, so slicing or deleting it as its base class loses nothing. Elements whose default
// constructor does nothing (TrianglePair) stay uninitialised when the list grows.
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

  // Moves the elements to `memory`, which must outlive the list, and stays there.
  void moveTo(std::pmr::memory_resource& memory) {
    HostList moved(*this, &memory);
    this->~HostList();
    new (this) HostList(std::move(moved));
  }

  // Reserves memory so that assigning `list` by a move does not allocate, whatever memory both use.
  // Reserves some more than needed, because allocations from a backend are slow.
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
