// Contacts as they are found, in bounded memory.
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

// A contact between two triangles of the working set, a < b. Hull: as in hull.h, here and below.
template <class Hull>
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

// How many contacts all lists of a cycle may hold together. Any number of threads.
class ContactRoom {
 public:
  // Upper bound of the memory of the contacts, from where they are found to the result [bytes].
  ContactRoom(std::uint64_t memory_limit_bytes, std::uint64_t bytes_each)
      : blocks_left_(std::clamp<std::int64_t>(
            static_cast<std::int64_t>(memory_limit_bytes / (kBlock * bytes_each)), 1,
            kMostContacts / kBlock)) {}

  // The list, the one by buckets, a bucket's own, and the result's.
  template <class Hull>
  static std::uint64_t bytesEach(bool geometry) {
    return 3 * sizeof(WorkingContact<Hull>) + sizeof(TrianglePair) +
           (kIsMoving<Hull> ? sizeof(FirstContact) + 1 : sizeof(float)) +
           (geometry ? sizeof(PairGeometry) : 0);
  }

  // Room for so many more; false if there is none.
  bool takeBlock() { return blocks_left_.fetch_sub(1, std::memory_order_relaxed) > 0; }

  static constexpr std::int64_t kBlock = 1024;

 private:
  static constexpr std::int64_t kMostContacts = std::int64_t{1} << 31;

  std::atomic<std::int64_t> blocks_left_;
};

// One thread's. In blocks, so that it never moves.
template <class Hull>
class ContactList {
 public:
  // Null: room without bound.
  explicit ContactList(ContactRoom* room = nullptr) : room_(room) {}

  // Counts it, and keeps it if there is room.
  void add(const WorkingContact<Hull>& contact) {
    if (room_in_block_ == 0 && !makeRoom()) {
      ++left_out_;
      return;
    }
    --room_in_block_;
    blocks_.back().push_back(contact);
  }

  // All of another's, which must not be used any more.
  void take(ContactList& other) {
    std::move(other.blocks_.begin(), other.blocks_.end(), std::back_inserter(blocks_));
    left_out_ += other.left_out_;
    room_in_block_ = 0;
  }

  const std::vector<std::vector<WorkingContact<Hull>>>& blocks() const { return blocks_; }
  std::size_t size() const {
    std::size_t size = 0;
    for (const std::vector<WorkingContact<Hull>>& block : blocks_) size += block.size();
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
  std::vector<std::vector<WorkingContact<Hull>>> blocks_;
  std::size_t room_in_block_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace deformable_contact_monitor
