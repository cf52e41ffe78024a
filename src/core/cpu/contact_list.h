// Stores contacts as they are found, in bounded memory.
//
// Every thread has a list of its own, made of blocks. All lists of a cycle take their blocks from
// one ContactRoom; once it is empty, contacts are counted but not stored.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include "core/common/index.h"
#include "core/cpu/primitive.h"
#include "core/detector.h"

namespace deformable_contact_monitor {

// A contact between two triangles of the working set, a < b.
template <class Primitive>
struct WorkingContact {
  TriangleIndex a, b;
  float separation_m = 0;
};

template <>
struct WorkingContact<MovingTriangle> {
  TriangleIndex a, b;
  FirstContact first;
  bool within_pad;  // as in DetectionResult
};

// Limits how many contacts all lists of a cycle hold together. Any number of threads may use it.
class ContactRoom {
 public:
  // `memory_limit_bytes` bounds the memory of all contacts, from where they are found to the
  // result.
  ContactRoom(std::uint64_t memory_limit_bytes, std::uint64_t bytes_each)
      : blocks_left_(std::clamp<std::int64_t>(
            static_cast<std::int64_t>(memory_limit_bytes / (kBlock * bytes_each)), 1,
            kMostContacts / kBlock)) {}

  // Returns the memory of one contact [bytes]: in the list, in the buckets, in a sorted bucket and
  // in the result.
  template <class Primitive>
  static std::uint64_t bytesEach(bool geometry) {
    return 3 * sizeof(WorkingContact<Primitive>) + sizeof(TrianglePair) +
           (kIsMoving<Primitive> ? sizeof(FirstContact) + 1 : sizeof(float)) +
           (geometry ? sizeof(PairGeometry) : 0);
  }

  // Takes room for kBlock contacts. Returns false if there is no room.
  bool takeBlock() { return blocks_left_.fetch_sub(1, std::memory_order_relaxed) > 0; }

  static constexpr std::int64_t kBlock = 1024;

 private:
  static constexpr std::int64_t kMostContacts = std::int64_t{1} << 31;

  std::atomic<std::int64_t> blocks_left_;
};

// The contacts of one thread. They lie in blocks, so that they never move.
template <class Primitive>
class ContactList {
 public:
  // `room` may be null: then memory is not bounded.
  explicit ContactList(ContactRoom* room = nullptr) : room_(room) {}

  // Stores the contact if there is room, and counts it otherwise.
  void add(const WorkingContact<Primitive>& contact) {
    if (room_in_block_ == 0 && !makeRoom()) {
      ++left_out_;
      return;
    }
    --room_in_block_;
    blocks_.back().push_back(contact);
  }

  // Moves all contacts of another list to this one. The other list must not be used afterwards.
  void take(ContactList& other) {
    std::move(other.blocks_.begin(), other.blocks_.end(), std::back_inserter(blocks_));
    left_out_ += other.left_out_;
    room_in_block_ = 0;
  }

  // Returns the blocks; their order depends on threads, so that the result must be sorted.
  const std::vector<std::vector<WorkingContact<Primitive>>>& blocks() const { return blocks_; }
  std::size_t size() const {
    std::size_t size = 0;
    for (const std::vector<WorkingContact<Primitive>>& block : blocks_) size += block.size();
    return size;
  }
  std::uint64_t leftOut() const { return left_out_; }

 private:
  bool makeRoom() {
    if (left_out_ > 0 || (room_ != nullptr && !room_->takeBlock())) return false;
    blocks_.emplace_back();
    blocks_.back().reserve(ContactRoom::kBlock);
    room_in_block_ = ContactRoom::kBlock;
    return true;
  }

  ContactRoom* room_;
  std::vector<std::vector<WorkingContact<Primitive>>> blocks_;
  std::size_t room_in_block_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace deformable_contact_monitor
